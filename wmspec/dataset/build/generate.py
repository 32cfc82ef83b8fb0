"""Generation: worker processes make instances, which are saved one by one until their shard is complete.

A failure costs one instance, or its group if that is made as a whole, and is recorded with its reason. After a crash or
timeout the instance is retried once, and again by the next run, since the machine may be the cause.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Iterator
from contextlib import closing
from dataclasses import dataclass, field
from itertools import groupby

from wmspec.core.crash import Crash
from wmspec.dataset.build.batching import Piece, batches, weight
from wmspec.dataset.build.checkpoint import transient
from wmspec.dataset.build.dataset import Dataset
from wmspec.dataset.build.plan import Plan, Shard
from wmspec.dataset.build.reuse import PriorInstances
from wmspec.dataset.build.worker import Balance, CacheStats, Job, Outcome, make_instances
from wmspec.lang.check.ir.ir import TaskSpec
from wmspec.lang.check.ir.record import to_json
from wmspec.runtime.questions.model import Rejected
from wmspec.runtime.workers.pool import JobFailure, PoolConfig, map_batches


@dataclass(frozen=True)
class RunStats:
    """Cache statistics, the cost of balancing answers by task, and the first unexpected error."""

    shared: CacheStats = field(default_factory=CacheStats)
    balance: dict[str, Balance] = field(default_factory=dict)
    crash: Crash | None = None


def generate(
    dataset: Dataset, effort: PoolConfig, progress: Callable[[str, int], None], before: PriorInstances
) -> RunStats:
    """Make every pending shard, except instances found in `before` or saved by an interrupted run.

    `progress` is called with a task and the number of its instances that were finished.
    """
    plan = dataset.plan
    pending = dataset.pending()
    if not pending:
        return RunStats()
    job, shared, balance = job_of(plan, effort), CacheStats(), dict[str, Balance]()
    crash: Crash | None = None
    specs = {task.spec.name: task.spec for task in plan.tasks}
    making = [_PendingShard(dataset, shard, before) for shard in pending]
    for one in making:
        progress(one.task, len(one.shard.indices) - len(one.missing))
        one.finish()
    shard_of = {(one.task, index): one for one in making for index in one.missing}
    with closing(
        map_batches(make_instances, _units(job, plan, making), effort, lambda p: weight(specs[p[1]], p[2]))
    ) as outcomes:
        for (_, task, indices), made in outcomes:
            if isinstance(made, JobFailure):
                crash = crash or made.crash
            else:
                shared += made.shared
                dataset.keep_films(made.films.items())
                if specs[task].plan.balance:
                    balance[task] = balance.get(task, Balance()) + made.balance
            for at, index in enumerate(indices):
                one = shard_of[task, index]
                spec = specs[task]
                one.keep(
                    index,
                    failed_outcome(plan, spec, index, made) if isinstance(made, JobFailure) else made.outcomes[at],
                )
                progress(task, 1)
    return RunStats(shared, balance, crash)


class _PendingShard:
    """A shard being made: its missing instances, and failures, which are not saved on disk."""

    def __init__(self, dataset: Dataset, shard: Shard, before: PriorInstances) -> None:
        self.shard, self.task = shard, shard.task.spec.name
        kept = dataset.kept(shard)
        self.missing = {index for index in before.missing(shard) if index not in kept}
        self._dataset, self._before = dataset, before
        self._failed: dict[int, Outcome] = {}

    def keep(self, index: int, outcome: Outcome) -> None:
        """Save the outcome of an instance, and write the shard after the last one."""
        self._dataset.keep(self.shard, index, outcome)
        if transient(outcome.rejected):
            self._failed[index] = outcome
        self.missing.remove(index)
        self.finish()

    def finish(self) -> None:
        """Write the shard if no instance is missing."""
        if not self.missing:
            before = self._before.outcomes(self.shard)
            self._dataset.keep_films(self._before.films(self.shard))
            made = self._dataset.kept(self.shard) | self._failed | before
            rows = [row for outcome in made.values() for row in outcome.rows]
            rejected = [r for outcome in made.values() for r in outcome.rejected]
            films = {path: sha for outcome in made.values() for path, sha in outcome.films.items()}
            self._dataset.write(self.shard, rows, rejected, films)


def _units(job: Job, plan: Plan, making: Iterable[_PendingShard]) -> Iterator[list[tuple[Job, str, Piece]]]:
    """Yield the work of all tasks in order, one unit of pieces at a time."""
    for task, shards in groupby(making, key=lambda one: one.task):
        of_task = list(shards)
        missing_indices = [index for one in of_task for index in one.shard.indices if index in one.missing]
        if missing_indices:
            own = job.of(task)
            for unit in batches(of_task[0].shard.task.spec, plan.seed, missing_indices):
                yield [(own, task, piece) for piece in unit]


def job_of(plan: Plan, effort: PoolConfig) -> Job:
    """Return the settings of the workers; call it before they start."""
    if effort.workers > 1:  # otherwise Mesa's software renderer starts a thread per core in every worker
        os.environ.setdefault("LP_NUM_THREADS", "0")
    tasks = tuple((t.spec.name, to_json(t.spec)) for t in plan.tasks)
    drawing = plan.look, plan.samples, plan.renderer
    return Job(tasks, plan.seed, plan.engines, plan.size, plan.consensus, *drawing, plan.rows_of, plan.film)


def failed_outcome(plan: Plan, spec: TaskSpec, index: int, lost: JobFailure) -> Outcome:
    """Return the outcome of a failed instance: every question of every row is rejected."""
    rejected = (
        Rejected(spec.name, index, q, engine or plan.reference, lost.kind, lost.reason)
        for engine in plan.row_engines
        for q in range(len(spec.questions))
    )
    return Outcome((), tuple(rejected))
