"""Cost estimates: a few instances of every task are made, timed and discarded."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from contextlib import closing
from dataclasses import dataclass, field
from time import perf_counter

from wmspec.core.crash import Crash
from wmspec.dataset.build.batching import Piece, batches, weight
from wmspec.dataset.build.generate import failed_outcome, job_of
from wmspec.dataset.build.manifest import by_reason
from wmspec.dataset.build.plan import Plan, Task
from wmspec.dataset.build.rows import schema, table
from wmspec.dataset.build.shards import parquet
from wmspec.dataset.build.worker import Balance, Job, Outcome, make_instances
from wmspec.runtime.questions.model import FAILED, Rejected
from wmspec.runtime.workers.pool import JobFailure, PoolConfig, map_ordered

#: Number of units timed for a task. The cost of an instance may depend on what differs between units, such as the
#: number of objects.
MAX_UNITS = 6
#: Maximum number of instances timed for a task; each unit has at least one piece.
MAX_TRIALS = 24


@dataclass(frozen=True)
class Cost:
    """The estimated cost of a task, from `tried` of its `instances`.

    `seconds` is the time of one worker for an instance, `error` its standard error over units. The error is None if
    only one of several units was timed. `size` is the number of bytes of an instance's questions in Parquet. `rejected`
    of the `questions` were rejected, with counts in `reasons` and one example each. `balance` is the cost of balancing
    answers, if any.
    """

    task: str
    instances: int
    tried: int
    seconds: float
    error: float | None
    size: float
    questions: int
    rejected: int
    reasons: dict[str, int]
    examples: dict[str, Rejected]
    balance: Balance | None = None
    failed: int = 0
    crash: Crash | None = field(default=None, repr=False)

    def hours(self, workers: int) -> float:
        """Return the hours that `workers` workers need for the whole task."""
        return self.instances * self.seconds / workers / 3600

    def standard_error(self, workers: int) -> float | None:
        """Return the standard error of `hours`, or None if unknown."""
        return None if self.error is None else self.instances * self.error / workers / 3600

    @property
    def bytes(self) -> float:
        """The size of the whole task on disk."""
        return self.instances * self.size


@dataclass(frozen=True)
class _Trial:
    """The outcomes of some pieces of a unit, and the seconds that each took."""

    seconds: tuple[float, ...]
    outcomes: tuple[Outcome, ...]
    balance: Balance


@dataclass(frozen=True)
class _Unit:
    """A unit of a task with the pieces to time. `other` is a piece of another unit, made first as a warm-up."""

    instances: int
    pieces: list[Piece]
    other: Piece


def estimate(plan: Plan, effort: PoolConfig, progress: Callable[[str, int], None]) -> tuple[Cost, ...]:
    """Make instances of units spread over every task, with all workers busy; `progress` is called for each task."""
    job = job_of(plan, effort)
    own = {task.spec.name: job.of(task.spec.name) for task in plan.tasks}
    todo = [(task.spec.name, unit) for task in plan.tasks for unit in _spaced_units(task, plan.seed)]
    pieces = [(own[name], name, unit.other, unit.pieces) for name, unit in todo]
    trials: dict[str, list[tuple[_Unit, _Trial | JobFailure]]] = {task.spec.name: [] for task in plan.tasks}
    specs = {task.spec.name: task.spec for task in plan.tasks}
    with closing(
        map_ordered(run_trial, pieces, effort, lambda p: sum(weight(specs[p[1]], x) for x in p[-1]))
    ) as outcomes:
        for number, ((name, unit), trial) in enumerate(zip(todo, outcomes, strict=True), 1):
            trials[name].append((unit, trial))
            if number == len(todo) or todo[number][0] != name:
                progress(name, 1)
    return tuple(_cost(plan, task, effort, trials[task.spec.name]) for task in plan.tasks)


#: The tasks of which this worker has made an instance: engines are started and scenes are cached.
_warm: set[str] = set()


def run_trial(job: Job, task: str, other: Piece, pieces: Sequence[Piece]) -> _Trial:
    """Make pieces and return the seconds they took, without the start-up cost of a worker.

    The warm-up uses `other`, because the results of the same piece would be cached.
    """
    if task not in _warm:
        make_instances(job, task, other)
        _warm.add(task)
    seconds, outcomes, balance = [], list[Outcome](), Balance()
    for piece in pieces:
        began = perf_counter()
        made = make_instances(job, task, piece)
        seconds.append(perf_counter() - began)
        outcomes += made.outcomes
        balance += made.balance
    return _Trial(tuple(seconds), tuple(outcomes), balance)


def _spaced_units(task: Task, seed: int) -> Iterator[_Unit]:
    """Yield units spread over a task; all units if they are few."""
    every = list(batches(task.spec, seed, task.indices))
    tried = min(MAX_UNITS, len(every))
    for i in range(tried):
        place = (2 * i + 1) * len(every) // (2 * tried)
        unit = every[place]
        yield _Unit(_size(unit), _first_pieces(unit, MAX_TRIALS // tried), every[place - 1][-1])


def _first_pieces(unit: list[Piece], most: int) -> list[Piece]:
    """Return the first pieces of a unit, with at most `most` instances in all.

    The remaining pieces share as much as the last of these.
    """
    return [piece for number, piece in enumerate(unit) if number == 0 or _size(unit[: number + 1]) <= most]


def _size(unit: Sequence[Piece]) -> int:
    """Return the number of instances of a unit."""
    return sum(map(len, unit))


def _cost(plan: Plan, task: Task, effort: PoolConfig, trials: list[tuple[_Unit, _Trial | JobFailure]]) -> Cost:
    """Return the estimate of a task from its trials."""
    whole = [trial for _, trial in trials if isinstance(trial, _Trial)]
    outcomes = [outcome for trial in whole for outcome in trial.outcomes]
    rows = [row for outcome in outcomes for row in outcome.rows]
    tried = sum(_size(unit.pieces) for unit, _ in trials)
    rejected = [r for outcome in outcomes for r in outcome.rejected]
    for unit, trial in trials:
        if isinstance(trial, JobFailure):
            nothings = (failed_outcome(plan, task.spec, index, trial) for piece in unit.pieces for index in piece)
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
        size=len(parquet(table(rows, schema(task.spec, plan.film is not None)))) / tried,
        questions=tried * len(task.spec.questions) * len(plan.row_engines),
        rejected=len(rejected),
        reasons=reasons,
        examples=examples,
        balance=sum((trial.balance for trial in whole), Balance()) if task.spec.plan.balance else None,
        failed=len({r.index for r in rejected if r.reason in FAILED}),
        crash=next((trial.crash for _, trial in trials if isinstance(trial, JobFailure) and trial.crash), None),
    )


def _seconds(unit: _Unit, trial: _Trial | JobFailure, effort: PoolConfig) -> float:
    """Return the time of a whole unit: its first piece has no cache to use, the others cost as much as those timed."""
    if isinstance(trial, JobFailure):
        return 2 * effort.timeout * unit.instances if trial.kind == "timeout" else 0.0  # one retry each
    first, others = len(unit.pieces[0]), _size(unit.pieces[1:])
    each = sum(trial.seconds[1:]) / others if others else trial.seconds[0] / first
    return trial.seconds[0] + each * (unit.instances - first)


def _rate(costs: list[tuple[float, int]], instances: int) -> tuple[float, float | None]:
    """Return the seconds for each instance and the standard error, from (seconds, instances) of units."""
    number, made = len(costs), sum(count for _, count in costs)
    rate = sum(seconds for seconds, _ in costs) / made
    if made == instances:
        return rate, 0.0
    if number == 1:
        return rate, None
    squares = sum((seconds - rate * count) ** 2 for seconds, count in costs)
    return rate, math.sqrt(squares / (number * (number - 1))) * number / made
