"""Making a dataset: instances go to worker processes and are kept one by one until their shard is whole and written.

What goes wrong with an instance costs that one, or its group if that is made as a whole; it is recorded with the
reason. A worker that crashes or hangs tries it once more, and so does the next run: that may have been the machine's.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from contextlib import closing
from itertools import groupby, islice

from wmspec.ask.closed import has_closed
from wmspec.ask.model import Rejected
from wmspec.check.record import to_json
from wmspec.design.design import Design
from wmspec.execute.pool import Effort, Lost, in_order
from wmspec.write.dataset import Dataset
from wmspec.write.plan import Plan, Shard
from wmspec.write.reuse import Before
from wmspec.write.worker import Job, Outcome, work


def generate(dataset: Dataset, effort: Effort, progress: Callable[[str, int], None], before: Before) -> None:
    """Make every pending shard, but for what was made `before`, or was kept by a run that was stopped.

    `progress` is told the task and the number of its instances that were finished.
    """
    plan = dataset.plan
    pending = dataset.pending()
    if not pending:
        return
    job = job_of(plan, effort)
    kept = {shard.path: dataset.kept(shard) for shard in pending}
    missing = {s.path: _pieces(s, plan.seed, [i for i in before.missing(s) if i not in kept[s.path]]) for s in pending}
    pieces = ((job, shard.task.spec.name, piece) for shard in pending for piece in missing[shard.path])
    with closing(in_order(work, pieces, effort, weight=lambda piece: len(piece[-1]))) as outcomes:
        for shard in pending:
            gathered, new = list((kept.pop(shard.path) | before.outcomes(shard)).values()), missing[shard.path]
            progress(shard.task.spec.name, len(gathered))
            for indices, outcome in zip(new, islice(outcomes, len(new)), strict=True):
                for at, index in enumerate(indices):
                    made = _lost(plan, shard, index, outcome) if isinstance(outcome, Lost) else outcome[at]
                    gathered.append(made)
                    dataset.keep(shard, index, made)
                    progress(shard.task.spec.name, 1)
            rows = [row for outcome in gathered for row in outcome.rows]
            dataset.write(shard, rows, [r for outcome in gathered for r in outcome.rejected])


def _pieces(shard: Shard, seed: int, indices: list[int]) -> list[tuple[int, ...]]:
    """The instances that go to a worker together: each alone, or those of a group that is made as a whole."""
    if not has_closed(shard.task.spec):
        return [(index,) for index in indices]
    design = Design(shard.task.spec, seed)
    return [tuple(of_one) for _, of_one in groupby(indices, key=lambda index: design.blocks.locate(index)[0])]


def job_of(plan: Plan, effort: Effort) -> Job:
    """What the workers are told; called before they start."""
    if effort.workers > 1:  # Mesa's software renderer would start a thread per core in every worker
        os.environ.setdefault("LP_NUM_THREADS", "0")
    tasks = tuple((t.spec.name, to_json(t.spec)) for t in plan.tasks)
    return Job(tasks, plan.seed, plan.engines, plan.size, plan.consensus, plan.look, plan.samples, plan.renderer)


def _lost(plan: Plan, shard: Shard, index: int, lost: Lost) -> Outcome:
    """What is recorded of an instance that came to nothing: all its questions are rejected in all engines."""
    spec = shard.task.spec
    rejected = (
        Rejected(spec.name, index, q, engine, lost.kind, lost.reason)
        for engine in plan.engines
        for q in range(len(spec.questions))
    )
    return Outcome((), tuple(rejected))
