"""What a dataset would cost: a few instances of every task are really made, timed, and thrown away."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import closing
from dataclasses import dataclass
from time import perf_counter

from wmspec.ask.closed import has_closed
from wmspec.check.orbits import MOST
from wmspec.execute.pool import Effort, Lost, in_order
from wmspec.write.generate import job_of
from wmspec.write.plan import Plan, Task
from wmspec.write.rows import schema, table
from wmspec.write.shards import parquet
from wmspec.write.worker import Job, Outcome, made_with, work


@dataclass(frozen=True)
class Cost:
    """What a task would take, judged by `tried` of its `instances`.

    `seconds` are what one worker needs for an instance, `size` the bytes of an instance's questions in Parquet;
    `rejected` of the `asked` questions were rejected.
    """

    task: str
    instances: int
    tried: int
    seconds: float
    size: float
    asked: int
    rejected: int

    def hours(self, workers: int) -> float:
        """How long so many workers need for the whole task, in hours."""
        return self.instances * self.seconds / workers / 3600

    @property
    def bytes(self) -> float:
        """What the whole task takes on the disk."""
        return self.instances * self.size


def estimate(plan: Plan, effort: Effort, count: int, progress: Callable[[str, int], None]) -> tuple[Cost, ...]:
    """Make `count` instances of every task, spread over its indices, with all workers busy as they would be."""
    job = job_of(plan, effort)
    pieces = [(job, task.spec.name, index, other) for task in plan.tasks for index, other in _spread(task, count)]
    made: dict[str, list[tuple[float, Outcome] | Lost]] = {task.spec.name: [] for task in plan.tasks}
    with closing(in_order(timed, pieces, effort)) as outcomes:
        for (_, name, *_), outcome in zip(pieces, outcomes, strict=True):
            made[name].append(outcome)
            progress(name, 1)
    return tuple(_cost(plan, task, effort, made[task.spec.name]) for task in plan.tasks)


#: The tasks that this worker process has made an instance of: its engines have started and its scenes are known.
_warm: set[str] = set()


def timed(job: Job, task: str, index: int, other: int) -> tuple[float, Outcome]:
    """Make an instance; the seconds it took, without what a worker needs once to get going.

    That is for making an `other` instance, because what the same one does would be known already. What is made with the
    whole of its group takes its share of that.
    """
    if task not in _warm:
        work(job, task, (other,))
        _warm.add(task)
    began = perf_counter()
    (outcome,) = work(job, task, (index,))
    return (perf_counter() - began) / made_with(job, task, index), outcome


def _spread(task: Task, count: int) -> Iterator[tuple[int, int]]:
    """Instances of a task, each with one before it."""
    tried = min(count, len(task.indices))
    places = ((2 * i + 1) * len(task.indices) // (2 * tried) for i in range(tried))
    apart = MOST if has_closed(task.spec) else 1  # not in the same group
    return ((task.indices[place], task.indices[(place - apart) % len(task.indices)]) for place in places)


def _cost(plan: Plan, task: Task, effort: Effort, made: list[tuple[float, Outcome] | Lost]) -> Cost:
    whole = [m for m in made if not isinstance(m, Lost)]
    rows = [row for _, outcome in whole for row in outcome.rows]
    lost = (len(made) - len(whole)) * len(task.spec.questions) * len(plan.engines)
    late = sum(isinstance(m, Lost) and m.kind == "timeout" for m in made)
    seconds = sum(s for s, _ in whole) + 2 * effort.timeout * late  # each was tried twice
    return Cost(
        task=task.spec.name,
        instances=len(task.indices),
        tried=len(made),
        seconds=seconds / len(made),
        size=len(parquet(table(rows, schema(task.spec)))) / len(made),
        asked=len(made) * len(task.spec.questions) * len(plan.engines),
        rejected=lost + sum(len(outcome.rejected) for _, outcome in whole),
    )
