"""What a dataset would cost: a few instances of every task are really made, timed, and thrown away."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import closing
from dataclasses import dataclass
from time import perf_counter

from wmspec.ask.model import Rejected
from wmspec.execute.pool import Effort, Lost, in_order
from wmspec.write.generate import job_of, nothing
from wmspec.write.manifest import by_reason
from wmspec.write.plan import Plan, Task
from wmspec.write.rows import schema, table
from wmspec.write.shards import parquet
from wmspec.write.units import Piece, units, weight
from wmspec.write.worker import Balance, Job, Outcome, work


@dataclass(frozen=True)
class Cost:
    """What a task would take, judged by `tried` of its `instances`.

    `seconds` are what one worker needs for an instance, `size` the bytes of an instance's questions in Parquet;
    `rejected` of the `asked` questions were rejected, so many for each of the `reasons`, with an example. `balance` is
    what the balance of answers cost, if there is one.
    """

    task: str
    instances: int
    tried: int
    seconds: float
    size: float
    asked: int
    rejected: int
    reasons: dict[str, int]
    examples: dict[str, Rejected]
    balance: Balance | None = None

    def hours(self, workers: int) -> float:
        """How long so many workers need for the whole task, in hours."""
        return self.instances * self.seconds / workers / 3600

    @property
    def bytes(self) -> float:
        """What the whole task takes on the disk."""
        return self.instances * self.size


#: Of a unit so many instances are tried.
TRIED = 16


@dataclass(frozen=True)
class _Trial:
    """What came of making a unit, and the seconds that took."""

    seconds: float
    outcomes: tuple[Outcome, ...]
    balance: Balance


def estimate(plan: Plan, effort: Effort, count: int, progress: Callable[[str, int], None]) -> tuple[Cost, ...]:
    """Make at least `count` instances of every task, in whole units from all over it, with all workers busy."""
    job = job_of(plan, effort)
    own = {task.spec.name: job.of(task.spec.name) for task in plan.tasks}
    pieces = [
        (own[task.spec.name], task.spec.name, *trial)
        for task in plan.tasks
        for trial in _spread(task, plan.seed, count)
    ]
    trials: dict[str, list[tuple[list[Piece], _Trial | Lost]]] = {task.spec.name: [] for task in plan.tasks}
    specs = {task.spec.name: task.spec for task in plan.tasks}
    with closing(in_order(timed, pieces, effort, lambda p: sum(weight(specs[p[1]], x) for x in p[-1]))) as outcomes:
        for (_, name, _, unit), trial in zip(pieces, outcomes, strict=True):
            trials[name].append((unit, trial))
            progress(name, _size(unit))
    return tuple(_cost(plan, task, effort, trials[task.spec.name]) for task in plan.tasks)


#: The tasks that this worker process has made an instance of: its engines have started and its scenes are known.
_warm: set[str] = set()


def timed(job: Job, task: str, other: Piece, unit: list[Piece]) -> _Trial:
    """Make a unit; the seconds it took, without what a worker needs once to get going.

    That is for making some `other` instance, because what the same one does would be known already.
    """
    if task not in _warm:
        work(job, task, other)
        _warm.add(task)
    began = perf_counter()
    made = [work(job, task, piece) for piece in unit]
    outcomes = tuple(outcome for one in made for outcome in one.outcomes)
    return _Trial(perf_counter() - began, outcomes, sum((one.balance for one in made), Balance()))


def _spread(task: Task, seed: int, count: int) -> Iterator[tuple[Piece, list[Piece]]]:
    """Units of a task with at least `count` instances together, each with a piece of the unit before."""
    every = list(units(task.spec, seed, task.indices))
    tried = min(-(-count * len(every) // len(task.indices)), len(every))
    places = ((2 * i + 1) * len(every) // (2 * tried) for i in range(tried))
    return ((every[place - 1][-1], _few(every[place])) for place in places)


def _few(unit: list[Piece]) -> list[Piece]:
    """The first pieces of a unit: as many as can be tried without much of a wait. The others share more with them."""
    return [piece for number, piece in enumerate(unit) if number == 0 or _size(unit[: number + 1]) <= TRIED]


def _size(unit: list[Piece]) -> int:
    return sum(map(len, unit))


def _cost(plan: Plan, task: Task, effort: Effort, trials: list[tuple[list[Piece], _Trial | Lost]]) -> Cost:
    whole = [trial for _, trial in trials if isinstance(trial, _Trial)]
    outcomes = [outcome for trial in whole for outcome in trial.outcomes]
    rows = [row for outcome in outcomes for row in outcome.rows]
    tried = sum(_size(unit) for unit, _ in trials)
    rejected = [r for outcome in outcomes for r in outcome.rejected]
    for unit, trial in trials:
        if isinstance(trial, Lost):
            nothings = (nothing(plan, task.spec, index, trial) for piece in unit for index in piece)
            rejected += (r for outcome in nothings for r in outcome.rejected)
    reasons, examples = by_reason(rejected)
    late = sum(_size(unit) for unit, trial in trials if isinstance(trial, Lost) and trial.kind == "timeout")
    seconds = sum(trial.seconds for trial in whole) + 2 * effort.timeout * late  # each was tried twice
    return Cost(
        task=task.spec.name,
        instances=len(task.indices),
        tried=tried,
        seconds=seconds / tried,
        size=len(parquet(table(rows, schema(task.spec)))) / tried,
        asked=tried * len(task.spec.questions) * len(plan.engines),
        rejected=len(rejected),
        reasons=reasons,
        examples=examples,
        balance=sum((trial.balance for trial in whole), Balance()) if task.spec.plan.balance else None,
    )
