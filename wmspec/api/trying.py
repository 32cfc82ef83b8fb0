"""Make a few instances of tasks through all gates, without writing a dataset."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence, Set
from contextlib import closing
from dataclasses import asdict, dataclass
from typing import Any

from wmspec.api.agreement import Tasks
from wmspec.api.generating import plan_dataset
from wmspec.api.loading import Tell, warn
from wmspec.api.progress import Progress, silent
from wmspec.compile.design.design import Design
from wmspec.compile.design.levels import format_levels
from wmspec.dataset.build.answer_counts import AnswerCounts, count_answers
from wmspec.dataset.build.batching import batches
from wmspec.dataset.build.generate import failed_outcome, job_of
from wmspec.dataset.build.manifest import by_reason
from wmspec.dataset.build.plan import Plan
from wmspec.dataset.build.plan import Task as PlannedTask
from wmspec.dataset.build.worker import Outcome, make_instances
from wmspec.runtime.engines.registry import default
from wmspec.runtime.questions.legibility.bounds import BOUNDS, ratio
from wmspec.runtime.questions.model import Legibility, Rejected
from wmspec.runtime.workers.pool import JobFailure, PoolConfig, map_ordered

#: Multiples of the number of instances that are tried while an answer does not vary.
MORE = (2, 4, 8)


@dataclass(frozen=True)
class TriedMeasure:
    """A measure over the kept instances of a question: the worst value, and the share that is within the bound."""

    name: str
    unit: str
    worst: float
    bound: float
    at_most: bool
    share: float


@dataclass(frozen=True)
class TriedQuestion:
    """A question of a tried task: kept instances, rejected ones by reason with examples, answers, and legibility.

    `legible` is the share of the kept instances that are within all bounds. `lost` are the levels of factors, such as
    `guide = curved`, of which several instances were tried and none is kept. `complete`: no more instances exist.
    """

    name: str
    kept: int
    rejected: Mapping[str, int]
    examples: Mapping[str, Rejected]
    answers: AnswerCounts
    measures: tuple[TriedMeasure, ...]
    legible: float
    lost: tuple[str, ...] = ()
    complete: bool = False

    @property
    def fault(self) -> str:
        """Why the question is useless as it is, or ''."""
        if not self.kept:
            return "no instance is kept"
        answers = list(self.answers.kept)
        if self.answers.dominant or (self.complete and len(answers) == 1 and self.kept > 1):
            return f"all {self.kept} kept instances have the answer `{answers[0]}`"
        return ""


@dataclass(frozen=True)
class TriedTask:
    """The tried instances of a task in one or more engines."""

    name: str
    engines: tuple[str, ...]
    instances: int
    questions: tuple[TriedQuestion, ...]

    @property
    def passed(self) -> bool:
        """Whether every question is kept, and not always with the same answer."""
        return not any(question.fault for question in self.questions)

    @property
    def is_undecided(self) -> bool:
        """Whether more instances may show that an answer varies, or that it never does."""
        return any(len(q.answers.kept) == 1 and not q.answers.dominant for q in self.questions)

    def record(self) -> dict[str, Any]:
        """Return the result as JSON values."""
        questions = [asdict(q) | {"warning": q.answers.shift, "fault": q.fault} for q in self.questions]
        return {"task": self.name, "engines": list(self.engines), "instances": self.instances, "questions": questions}


def try_tasks(
    tasks: Tasks,
    count: int = 4,
    *,
    backend: str = "",
    seed: int = 0,
    progress: Progress = silent,
    tell: Tell = warn,
) -> tuple[TriedTask, ...]:
    """Make `count` random instances of each task in this process, and return what the gates keep.

    Control groups are whole, so a task may have more instances. While all kept instances of a question have the same
    answer, and that may be chance, their number is doubled, up to eight times. `backend` names engines as for
    `generate`; by default it is the first that is installed. Raises WmsError where `generate` would.
    """
    engine = backend or default()
    plan = plan_dataset(tasks, tell, per_task=count, backend=engine, seed=seed)
    with progress(sum(len(task.indices) for task in plan.tasks), "trying") as advance:
        tried = []
        for task in plan.tasks:
            outcomes, done = list(_outcomes(plan, task, task.indices)), set(task.indices)
            advance(task.spec.name, len(task.indices))
            tried.append(_summary(plan, task, outcomes))
            for more in MORE:
                if not tried[-1].is_undecided:
                    break
                wider = plan_dataset(tasks, _nothing, per_task=more * count, backend=engine, seed=seed)
                sample = next(own for own in wider.tasks if own.spec.name == task.spec.name)
                outcomes += _outcomes(wider, sample, [index for index in sample.indices if index not in done])
                done |= set(sample.indices)
                tried[-1] = _summary(wider, sample, outcomes)
    return tuple(tried)


def _nothing(_notice: str) -> None:
    """Ignore a notice that was given before."""


def _summary(plan: Plan, task: PlannedTask, outcomes: Sequence[Outcome]) -> TriedTask:
    rows = [row for outcome in outcomes for row in outcome.rows]
    rejected = [each for outcome in outcomes for each in outcome.rejected]
    counts, design = count_answers(task.spec, rows, rejected), Design(task.spec, plan.seed)
    complete = len(task.indices) == len(design)
    questions = []
    for q, question in enumerate(task.spec.questions):
        kept = [row for row in rows if row["question"] == q]
        lost = [each for each in rejected if each.question == q]
        measures = [[Legibility(**each) for each in row["legibility"]] for row in kept]
        legible = sum(all(ratio(each) >= 1 for each in own) for own in measures) / len(kept) if kept else 0.0
        name = question.name or f"question {q + 1}"
        levels = _lost_levels(design, {row["index"] for row in kept}, {each.index for each in lost})
        found = len(kept), *by_reason(lost), counts[q], _measures(measures), legible
        questions.append(TriedQuestion(name, *found, levels, complete))
    return TriedTask(task.spec.name, plan.engines, len(task.indices), tuple(questions))


def _lost_levels(design: Design, kept: Set[int], rejected: Set[int]) -> tuple[str, ...]:
    """Return the levels, with their factors, of two or more rejected instances and no kept one, if some are kept."""
    there, gone = (
        Counter(level for index in indices for level in design[index].factors.items())
        for indices in (kept, sorted(rejected - kept))
    )
    lost = [level for level, count in gone.items() if count > 1 and level not in there]
    return tuple(format_levels(design.factors, dict([level])) for level in lost) if there else ()


def _outcomes(plan: Plan, task: PlannedTask, indices: Sequence[int]) -> Iterator[Outcome]:
    """Yield the outcomes of instances of a task."""
    effort, name = PoolConfig(0, 0), task.spec.name
    job = job_of(plan, effort).of(name)
    pieces = [piece for unit in batches(task.spec, plan.seed, indices) for piece in unit]
    with closing(map_ordered(make_instances, ((job, name, piece) for piece in pieces), effort)) as made:
        for piece, result in zip(pieces, made, strict=True):
            if isinstance(result, JobFailure):
                yield from (failed_outcome(plan, task.spec, index, result) for index in piece)
            else:
                yield from result.outcomes


def _measures(rows: Sequence[Sequence[Legibility]]) -> tuple[TriedMeasure, ...]:
    """Return every measure that applies to a row, in the order of the table of bounds."""
    tried = []
    for name, bound in BOUNDS.items():
        own = [each for row in rows for each in row if each.name == name]
        if own:
            worst = min(own, key=ratio).value
            share = sum(ratio(each) >= 1 for each in own) / len(own)
            tried.append(TriedMeasure(name, bound.unit, worst, bound.value, bound.at_most, share))
    return tuple(tried)
