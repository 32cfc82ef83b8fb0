"""Making a dataset: instances go to worker processes and are kept one by one until their shard is whole and written.

What goes wrong with an instance costs that one, or its group if that is made as a whole; it is recorded with the
reason. A worker that crashes or hangs tries it once more, and so does the next run: that may have been the machine's.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Iterator
from contextlib import closing
from dataclasses import dataclass, field
from itertools import groupby

from wmspec.core.crash import Crash
from wmspec.dataset.build.checkpoint import passing
from wmspec.dataset.build.dataset import Dataset
from wmspec.dataset.build.plan import Plan, Shard
from wmspec.dataset.build.reuse import Before
from wmspec.dataset.build.units import Piece, units, weight
from wmspec.dataset.build.worker import Balance, Job, Outcome, Sharing, work
from wmspec.lang.check.ir.ir import TaskSpec
from wmspec.lang.check.ir.record import to_json
from wmspec.runtime.questions.model import Rejected
from wmspec.runtime.workers.pool import Effort, Lost, by_units


@dataclass(frozen=True)
class Spent:
    """How much of the work was shared, what the balance of answers cost, by task, and the first unexpected error."""

    shared: Sharing = field(default_factory=Sharing)
    balance: dict[str, Balance] = field(default_factory=dict)
    crash: Crash | None = None


def generate(dataset: Dataset, effort: Effort, progress: Callable[[str, int], None], before: Before) -> Spent:
    """Make every pending shard, but for what was made `before`, or was kept by a run that was stopped.

    `progress` is told the task and the number of its instances that were finished.
    """
    plan = dataset.plan
    pending = dataset.pending()
    if not pending:
        return Spent()
    job, shared, balance = job_of(plan, effort), Sharing(), dict[str, Balance]()
    crash: Crash | None = None
    specs = {task.spec.name: task.spec for task in plan.tasks}
    making = [_Making(dataset, shard, before) for shard in pending]
    for one in making:
        progress(one.task, len(one.shard.indices) - len(one.missing))
        one.finish()
    shard_of = {(one.task, index): one for one in making for index in one.missing}
    with closing(by_units(work, _units(job, plan, making), effort, lambda p: weight(specs[p[1]], p[2]))) as outcomes:
        for (_, task, indices), made in outcomes:
            if isinstance(made, Lost):
                crash = crash or made.crash
            else:
                shared += made.shared
                if specs[task].plan.balance:
                    balance[task] = balance.get(task, Balance()) + made.balance
            for at, index in enumerate(indices):
                one = shard_of[task, index]
                spec = specs[task]
                one.keep(index, nothing(plan, spec, index, made) if isinstance(made, Lost) else made.outcomes[at])
                progress(task, 1)
    return Spent(shared, balance, crash)


class _Making:
    """A shard in the making: what is missing of it, and what is not kept on the disk because it failed."""

    def __init__(self, dataset: Dataset, shard: Shard, before: Before) -> None:
        self.shard, self.task = shard, shard.task.spec.name
        kept = dataset.kept(shard)
        self.missing = {index for index in before.missing(shard) if index not in kept}
        self._dataset, self._before = dataset, before
        self._failed: dict[int, Outcome] = {}

    def keep(self, index: int, outcome: Outcome) -> None:
        """Write down what came of an instance, and the shard if it was the last."""
        self._dataset.keep(self.shard, index, outcome)
        if passing(outcome.rejected):
            self._failed[index] = outcome
        self.missing.remove(index)
        self.finish()

    def finish(self) -> None:
        """Write the shard if nothing of it is missing."""
        if not self.missing:
            made = self._dataset.kept(self.shard) | self._failed | self._before.outcomes(self.shard)
            rows = [row for outcome in made.values() for row in outcome.rows]
            self._dataset.write(self.shard, rows, [r for outcome in made.values() for r in outcome.rejected])


def _units(job: Job, plan: Plan, making: Iterable[_Making]) -> Iterator[list[tuple[Job, str, Piece]]]:
    """What the workers get, one task after the other."""
    for task, shards in groupby(making, key=lambda one: one.task):
        of_task = list(shards)
        wanted = [index for one in of_task for index in one.shard.indices if index in one.missing]
        if wanted:
            own = job.of(task)
            for unit in units(of_task[0].shard.task.spec, plan.seed, wanted):
                yield [(own, task, piece) for piece in unit]


def job_of(plan: Plan, effort: Effort) -> Job:
    """What the workers are told; called before they start."""
    if effort.workers > 1:  # Mesa's software renderer would start a thread per core in every worker
        os.environ.setdefault("LP_NUM_THREADS", "0")
    tasks = tuple((t.spec.name, to_json(t.spec)) for t in plan.tasks)
    return Job(tasks, plan.seed, plan.engines, plan.size, plan.consensus, plan.look, plan.samples, plan.renderer)


def nothing(plan: Plan, spec: TaskSpec, index: int, lost: Lost) -> Outcome:
    """What is recorded of an instance that came to nothing: all its questions are rejected in all engines."""
    rejected = (
        Rejected(spec.name, index, q, engine, lost.kind, lost.reason)
        for engine in plan.engines
        for q in range(len(spec.questions))
    )
    return Outcome((), tuple(rejected))
