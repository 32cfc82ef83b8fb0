"""Making a dataset: instances go to worker processes, shards are written as soon as they are whole.

A worker that crashes or hangs costs the instance it was at, which is tried once more and then recorded as failed.
"""

from __future__ import annotations

import os
from collections import deque
from collections.abc import Callable, Iterator
from concurrent.futures import TimeoutError as FutureTimeout
from contextlib import contextmanager
from dataclasses import dataclass
from multiprocessing import get_context
from typing import Any

from pebble import ProcessExpired, ProcessPool

from wmspec.ask.model import Reason, Rejected
from wmspec.write.dataset import Dataset
from wmspec.write.plan import Plan, Shard
from wmspec.write.work import Job, Outcome, work

#: A worker is replaced after so many instances, which bounds whatever an engine leaks.
INSTANCES_PER_WORKER = 500


@dataclass(frozen=True)
class Effort:
    """How hard to try: worker processes, and the seconds that an instance may take."""

    workers: int
    timeout: float


def generate(dataset: Dataset, effort: Effort, progress: Callable[[str, int], None]) -> None:
    """Make every pending shard. `progress` is told the task and the number of its instances that were finished."""
    plan = dataset.plan
    pending = dataset.pending()
    if not pending:
        return
    with _pool(effort.workers) as pool:
        asking = _Asking(pool, plan, effort)
        outcomes = asking.in_order([(shard, i) for shard in pending for i in shard.indices])
        for shard in pending:
            gathered = [_told(next(outcomes), shard, progress) for _ in shard.indices]
            rows = [row for outcome in gathered for row in outcome.rows]
            dataset.write(shard, rows, [r for outcome in gathered for r in outcome.rejected])


def _told(outcome: Outcome, shard: Shard, progress: Callable[[str, int], None]) -> Outcome:
    progress(shard.task.spec.name, 1)
    return outcome


@contextmanager
def _pool(workers: int) -> Iterator[Any]:
    if workers > 1:  # Mesa's software renderer would start a thread per core in every worker
        os.environ.setdefault("LP_NUM_THREADS", "0")
    pool = ProcessPool(max_workers=workers, max_tasks=INSTANCES_PER_WORKER, context=get_context("spawn"))
    try:
        yield pool
        pool.close()
    except BaseException:
        pool.stop()
        raise
    finally:
        pool.join()


class _Asking:
    def __init__(self, pool: Any, plan: Plan, effort: Effort) -> None:
        self.pool = pool
        self.plan = plan
        self.effort = effort
        tasks = tuple((t.spec.name, t.spec.model_dump_json()) for t in plan.tasks)
        self.job = Job(tasks, plan.seed, plan.engines, plan.size, plan.consensus)

    def in_order(self, instances: list[tuple[Shard, int]]) -> Iterator[Outcome]:
        """The outcomes of the instances in their order, with only as many under way as keep the workers busy."""
        under_way: deque[tuple[Shard, int, Any]] = deque()
        for shard, index in instances:
            under_way.append((shard, index, self.schedule(shard, index)))
            if len(under_way) > 4 * self.effort.workers:
                yield self.result(*under_way.popleft())
        while under_way:
            yield self.result(*under_way.popleft())

    def schedule(self, shard: Shard, index: int) -> Any:
        return self.pool.schedule(work, args=(self.job, shard.task.spec.name, index), timeout=self.effort.timeout)

    def result(self, shard: Shard, index: int, future: Any) -> Outcome:
        try:
            return _outcome(future)
        except (ProcessExpired, FutureTimeout):
            try:
                return _outcome(self.schedule(shard, index))
            except FutureTimeout:
                return self.failed(shard, index, "timeout", f"took longer than {self.effort.timeout:g} s, twice")
            except ProcessExpired as error:
                return self.failed(
                    shard, index, "crashed", f"the worker process died twice (exit code {error.exitcode})"
                )

    def failed(self, shard: Shard, index: int, reason: Reason, detail: str) -> Outcome:
        spec = shard.task.spec
        rejected = (
            Rejected(spec.name, index, q, engine, reason, detail)
            for engine in self.plan.engines
            for q in range(len(spec.questions))
        )
        return Outcome((), tuple(rejected))


def _outcome(future: Any) -> Outcome:
    outcome = future.result()
    assert isinstance(outcome, Outcome)
    return outcome
