"""What a dataset would cost: a few instances of every task are really made, timed, and thrown away."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from contextlib import closing
from dataclasses import dataclass, field
from time import perf_counter

from wmspec.core.crash import Crash
from wmspec.dataset.build.generate import job_of, nothing
from wmspec.dataset.build.manifest import by_reason
from wmspec.dataset.build.plan import Plan, Task
from wmspec.dataset.build.rows import schema, table
from wmspec.dataset.build.shards import parquet
from wmspec.dataset.build.units import Piece, units, weight
from wmspec.dataset.build.worker import Balance, Job, Outcome, work
from wmspec.runtime.questions.model import FAILED, Rejected
from wmspec.runtime.workers.pool import Effort, Lost, in_order

#: Of a task so many units are tried: what an instance costs may hang on what they differ in, such as how many things.
UNITS = 6
#: Of all of them so many instances, or one piece of each.
TRIED = 24


@dataclass(frozen=True)
class Cost:
    """What a task would take, judged by `tried` of its `instances`.

    `seconds` are what one worker needs for an instance, known to within `error` (one standard error, by how units
    differ; None of a single one of several); `size` is the bytes of an instance's questions in Parquet; `rejected` of
    the `asked` questions were rejected, so many for each of the `reasons`, with an example. `balance` is what the
    balance of answers cost, if there is one. `failed` of those tried ended as internal errors, crashes or timeouts;
    `crash` is the first unexpected error.
    """

    task: str
    instances: int
    tried: int
    seconds: float
    error: float | None
    size: float
    asked: int
    rejected: int
    reasons: dict[str, int]
    examples: dict[str, Rejected]
    balance: Balance | None = None
    failed: int = 0
    crash: Crash | None = field(default=None, repr=False)

    def hours(self, workers: int) -> float:
        """How long so many workers need for the whole task, in hours."""
        return self.instances * self.seconds / workers / 3600

    def within(self, workers: int) -> float | None:
        """One standard error of these hours, if it is known."""
        return None if self.error is None else self.instances * self.error / workers / 3600

    @property
    def bytes(self) -> float:
        """What the whole task takes on the disk."""
        return self.instances * self.size


@dataclass(frozen=True)
class _Trial:
    """What came of making some pieces of a unit, and the seconds that each took."""

    seconds: tuple[float, ...]
    outcomes: tuple[Outcome, ...]
    balance: Balance


@dataclass(frozen=True)
class _Unit:
    """A unit of a task, so many instances, of which some pieces are tried after `other`, one of the unit before."""

    instances: int
    pieces: list[Piece]
    other: Piece


def estimate(plan: Plan, effort: Effort, progress: Callable[[str, int], None]) -> tuple[Cost, ...]:
    """Make some instances of units from all over every task, with all workers busy; `progress` is told of each task."""
    job = job_of(plan, effort)
    own = {task.spec.name: job.of(task.spec.name) for task in plan.tasks}
    todo = [(task.spec.name, unit) for task in plan.tasks for unit in _spread(task, plan.seed)]
    pieces = [(own[name], name, unit.other, unit.pieces) for name, unit in todo]
    trials: dict[str, list[tuple[_Unit, _Trial | Lost]]] = {task.spec.name: [] for task in plan.tasks}
    specs = {task.spec.name: task.spec for task in plan.tasks}
    with closing(in_order(timed, pieces, effort, lambda p: sum(weight(specs[p[1]], x) for x in p[-1]))) as outcomes:
        for number, ((name, unit), trial) in enumerate(zip(todo, outcomes, strict=True), 1):
            trials[name].append((unit, trial))
            if number == len(todo) or todo[number][0] != name:
                progress(name, 1)
    return tuple(_cost(plan, task, effort, trials[task.spec.name]) for task in plan.tasks)


#: The tasks that this worker process has made an instance of: its engines have started and its scenes are known.
_warm: set[str] = set()


def timed(job: Job, task: str, other: Piece, pieces: Sequence[Piece]) -> _Trial:
    """Make some pieces; the seconds they took, without what a worker needs once to get going.

    That is for making some `other` instance, because what the same one does would be known already.
    """
    if task not in _warm:
        work(job, task, other)
        _warm.add(task)
    seconds, outcomes, balance = [], list[Outcome](), Balance()
    for piece in pieces:
        began = perf_counter()
        made = work(job, task, piece)
        seconds.append(perf_counter() - began)
        outcomes += made.outcomes
        balance += made.balance
    return _Trial(tuple(seconds), tuple(outcomes), balance)


def _spread(task: Task, seed: int) -> Iterator[_Unit]:
    """Units from all over a task, all if they are few."""
    every = list(units(task.spec, seed, task.indices))
    tried = min(UNITS, len(every))
    for i in range(tried):
        place = (2 * i + 1) * len(every) // (2 * tried)
        unit = every[place]
        yield _Unit(_size(unit), _few(unit, TRIED // tried), every[place - 1][-1])


def _few(unit: list[Piece], most: int) -> list[Piece]:
    """The first pieces of a unit, of so many instances at most: the others share as the last of these do."""
    return [piece for number, piece in enumerate(unit) if number == 0 or _size(unit[: number + 1]) <= most]


def _size(unit: Sequence[Piece]) -> int:
    return sum(map(len, unit))


def _cost(plan: Plan, task: Task, effort: Effort, trials: list[tuple[_Unit, _Trial | Lost]]) -> Cost:
    whole = [trial for _, trial in trials if isinstance(trial, _Trial)]
    outcomes = [outcome for trial in whole for outcome in trial.outcomes]
    rows = [row for outcome in outcomes for row in outcome.rows]
    tried = sum(_size(unit.pieces) for unit, _ in trials)
    rejected = [r for outcome in outcomes for r in outcome.rejected]
    for unit, trial in trials:
        if isinstance(trial, Lost):
            nothings = (nothing(plan, task.spec, index, trial) for piece in unit.pieces for index in piece)
            rejected += (r for outcome in nothings for r in outcome.rejected)
    reasons, examples = by_reason(rejected)
    seconds, error = _rate(
        [(_seconds(unit, trial, effort), unit.instances) for unit, trial in trials], len(task.indices)
    )
    return Cost(
        task=task.spec.name,
        instances=len(task.indices),
        tried=tried,
        seconds=seconds,
        error=error,
        size=len(parquet(table(rows, schema(task.spec)))) / tried,
        asked=tried * len(task.spec.questions) * len(plan.engines),
        rejected=len(rejected),
        reasons=reasons,
        examples=examples,
        balance=sum((trial.balance for trial in whole), Balance()) if task.spec.plan.balance else None,
        failed=len({r.index for r in rejected if r.reason in FAILED}),
        crash=next((trial.crash for _, trial in trials if isinstance(trial, Lost) and trial.crash), None),
    )


def _seconds(unit: _Unit, trial: _Trial | Lost, effort: Effort) -> float:
    """What a whole unit would take: its first piece finds nothing known, and the others are like those tried."""
    if isinstance(trial, Lost):
        return 2 * effort.timeout * unit.instances if trial.kind == "timeout" else 0.0  # each is tried twice
    first, others = len(unit.pieces[0]), _size(unit.pieces[1:])
    each = sum(trial.seconds[1:]) / others if others else trial.seconds[0] / first
    return trial.seconds[0] + each * (unit.instances - first)


def _rate(costs: list[tuple[float, int]], instances: int) -> tuple[float, float | None]:
    """Seconds for each of so many `instances`, by what units take and how many they are, and the standard error."""
    number, made = len(costs), sum(count for _, count in costs)
    rate = sum(seconds for seconds, _ in costs) / made
    if made == instances:
        return rate, 0.0
    if number == 1:
        return rate, None
    squares = sum((seconds - rate * count) ** 2 for seconds, count in costs)
    return rate, math.sqrt(squares / (number * (number - 1))) * number / made
