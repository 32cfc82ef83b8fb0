"""Verification: recomputes what follows from specs and seed, makes a random sample of questions again, and compares.

A dataset is not believed: ids, order, counts and the values of factors are computed from specs and seed for every row;
card, metadata, examples and manifest from the rows; and the rest of a row, which takes an engine, for a random sample.
With the same engines and graphics driver all bytes are equal. On another machine the last digits of a simulation and
pixels at edges may differ. Then texts, options and answers must be equal, numbers and pictures nearly equal.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from contextlib import closing
from dataclasses import dataclass, replace

from wmspec.compile.design.design import Design
from wmspec.dataset.build.batching import batches, weight
from wmspec.dataset.build.generate import job_of
from wmspec.dataset.build.identity import identity
from wmspec.dataset.build.plan import Plan, Task
from wmspec.dataset.build.reader import DatasetReader
from wmspec.dataset.build.rows import Row
from wmspec.dataset.build.worker import Outcome, make_instances
from wmspec.dataset.verify.compare import compare, film_differences, option_scores
from wmspec.dataset.verify.marks import OptionScores, marked_truths
from wmspec.dataset.verify.model import Difference, Power
from wmspec.dataset.verify.records import PlannedQuestion, Records
from wmspec.dataset.verify.sample import SHARE, draw, found, sample_size
from wmspec.lang.check.ir.ir import TaskSpec
from wmspec.runtime.questions.closed_sets import has_closed_set
from wmspec.runtime.questions.model import Rejected
from wmspec.runtime.workers.pool import JobFailure, PoolConfig, map_batches


@dataclass(frozen=True)
class Sample:
    """Instances to make again, by task, and what the random draw behind them finds."""

    tasks: tuple[Task, ...]
    power: Power

    @property
    def size(self) -> int:
        """The number of instances."""
        return sum(len(task.indices) for task in self.tasks)


def draw_sample(plan: Plan, records: Records, count: int | None, every: bool, seed: int) -> Sample:
    """Draw kept and rejected questions at random, at least one of each task, and return their instances.

    `count` questions of each kind are drawn; by default, as many as find a change in 5 % of them with 99 %. Instances
    that are made together with a drawn one are included.
    """
    kept, rejected = records.kept, list(records.rejected)
    sizes = [len(one) if every else count or sample_size(len(one)) for one in (kept, rejected)]
    drawn = {*draw(kept, sizes[0], seed, "rows"), *draw(rejected, sizes[1], seed, "rejections")}
    for task in plan.tasks:
        of_task = [question for question in kept if question.task == task.spec.name]
        drawn |= {*draw(of_task, 1, seed, task.spec.name)}
    tasks = tuple(_with_partners(task, plan.seed, drawn, every) for task in plan.tasks)
    least = min(found(len(one), min(size, len(one))) for one, size in zip((kept, rejected), sizes, strict=True))
    return Sample(tuple(task for task in tasks if task.indices), Power(SHARE, 1.0 if every else least))


def _with_partners(task: Task, seed: int, drawn: Iterable[PlannedQuestion], every: bool) -> Task:
    """Return the task with the drawn instances, and those of the dataset that are made together with them."""
    if every:
        return task
    chosen = {question.index for question in drawn if question.task == task.spec.name}
    if task.spec.plan.balance or has_closed_set(task.spec):
        design = Design(task.spec, seed)
        groups = {group for i in chosen for group in design.balance_batch(design.blocks.locate(i)[0])}
        chosen |= {member for group in groups for member in design.blocks.members(group)}
    return replace(task, indices=tuple(i for i in task.indices if i in chosen))


def regenerate(
    dataset: DatasetReader, plan: Plan, records: Records, effort: PoolConfig, progress: Callable[[str, int], None]
) -> tuple[int, list[Difference]]:
    """Make the instances of `plan`, a sample of the dataset, again and compare them.

    Returns the number of questions made again, and the differences.
    """
    job, specs = job_of(plan, effort), {task.spec.name: task.spec for task in plan.tasks}
    comparison = _Comparison(plan, records)
    every = (
        [(job.of(task.spec.name), task.spec.name, piece) for piece in unit]
        for task in plan.tasks
        for unit in batches(task.spec, plan.seed, task.indices)
    )
    with closing(map_batches(make_instances, every, effort, lambda p: weight(specs[p[1]], p[2]))) as outcomes:
        for (_, name, indices), made in outcomes:
            there = _stored_rows(dataset, name, set(indices))
            if not isinstance(made, JobFailure):
                comparison.differences += film_differences(dataset, made.films)
            for at, index in enumerate(indices):
                outcome = made if isinstance(made, JobFailure) else made.outcomes[at]
                comparison.instance(specs[name], index, there, outcome)
                progress(name, 1)
    return comparison.questions, [*comparison.differences, *marked_truths(comparison.scores)]


class _Comparison:
    """Compares instances one by one and collects differences and the scores of options."""

    def __init__(self, plan: Plan, records: Records) -> None:
        self.questions = 0
        self.differences: list[Difference] = []
        self.scores: list[OptionScores] = []
        self._plan = plan
        self._rejected = {question.id: rejection for question, rejection in records.rejected.items()}

    def instance(self, spec: TaskSpec, index: int, there: Mapping[str, Row], outcome: Outcome | JobFailure) -> None:
        """Compare all questions of an instance."""
        here = self._by_id(outcome)
        for engine in self._plan.row_engines:
            for q in range(len(spec.questions)):
                id_ = identity(self._plan.seed, spec.name, index, q, engine)
                made = outcome if isinstance(outcome, JobFailure) else here.get(id_)
                row = there.get(id_)
                found = list(compare(id_, row, made, self._rejected.get(id_)))
                self.differences += found
                self.questions += 1
                if found and row is not None and isinstance(made, dict) and row["answer"] is not None:
                    scores = option_scores(row, made)
                    self.scores += [OptionScores(scores, row["answer"])] if scores else []

    def _by_id(self, outcome: Outcome | JobFailure) -> dict[str, Row | Rejected]:
        """Return rows and rejections by the id of their question."""
        if isinstance(outcome, JobFailure):
            return {}
        per_engine, seed = self._plan.rows_of == "engines", self._plan.seed
        rejected = {
            identity(seed, r.task, r.index, r.question, r.engine if per_engine else None): r for r in outcome.rejected
        }
        return {**rejected, **{row["id"]: row for row in outcome.rows}}


def _stored_rows(dataset: DatasetReader, task: str, indices: set[int]) -> dict[str, Row]:
    """Return the dataset's rows of the given instances, by id."""
    columns = dataset.columns(task)
    return {row["id"]: row for row in dataset.rows(task, columns, indices)} if columns else {}


def strict(differences: Iterable[Difference]) -> list[Difference]:
    """Return the differences with none of them near, for a dataset that this machine must make to the byte."""
    return [replace(difference, near=False) for difference in differences]
