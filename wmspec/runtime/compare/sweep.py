"""Checks many instances of many tasks in worker processes."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import closing
from dataclasses import dataclass, replace
from functools import cache, lru_cache
from itertools import combinations

from wmspec.compile.design.design import Design
from wmspec.lang.check.ir.ir import TaskSpec
from wmspec.lang.check.ir.record import from_json
from wmspec.runtime.caches.trace_cache import TraceCache
from wmspec.runtime.compare.check import check
from wmspec.runtime.compare.model import CheckResult, Failure, Pair
from wmspec.runtime.compare.tolerance import Tolerances
from wmspec.runtime.workers.pool import JobFailure, PoolConfig, map_ordered


@dataclass(frozen=True)
class SweepConfig:
    """Settings of all checks: `tasks` are `TaskSpec`s as JSON, with their `tolerances`, by name."""

    tasks: tuple[tuple[str, str], ...]
    seed: int
    engines: tuple[str, ...]
    tolerances: tuple[tuple[str, Tolerances], ...]

    def of(self, task: str) -> SweepConfig:
        """Return the settings for one task, to be sent with every job."""
        tasks = tuple(pair for pair in self.tasks if pair[0] == task)
        return replace(self, tasks=tasks, tolerances=tuple(pair for pair in self.tolerances if pair[0] == task))


@dataclass(frozen=True)
class Swept:
    """The instances that were checked, how many of them failed before anything was compared, and the first cause."""

    checked: tuple[CheckResult, ...]
    failed: int = 0
    cause: JobFailure | None = None


def pairs(engines: Sequence[str]) -> list[Pair]:
    """Return every pair of engines, in order."""
    return list(combinations(engines, 2))


def sweep(
    specs: Sequence[TaskSpec],
    sample: int,
    job: SweepConfig,
    effort: PoolConfig,
    progress: Callable[[str, int], None],
) -> Swept:
    """Return the checks of `sample` random instances per task, ordered by task and index.

    `progress` is called with the task and the number of its finished instances.
    """
    designs = {spec.name: Design(spec, job.seed) for spec in specs}
    todo = [(name, index) for name, design in designs.items() for index in sorted(design.sample(sample))]
    checked, lost, own = list[CheckResult](), list[JobFailure](), {name: job.of(name) for name in designs}
    with closing(map_ordered(work, ((own[name], name, index) for name, index in todo), effort)) as outcomes:
        for (name, index), outcome in zip(todo, outcomes, strict=True):
            if isinstance(outcome, JobFailure):
                lost.append(outcome)
            checked.append(_lost(designs[name], index, outcome) if isinstance(outcome, JobFailure) else outcome)
            progress(name, 1)
    return Swept(tuple(checked), len(lost), next((one for one in lost if one.crash), lost[0] if lost else None))


def work(job: SweepConfig, task: str, index: int) -> CheckResult:
    """Check an instance, in a worker process."""
    return check(_design(job, task), index, _executors(job.engines), dict(job.tolerances)[task])


@lru_cache(maxsize=4)
def _design(job: SweepConfig, task: str) -> Design:
    return Design(from_json(dict(job.tasks)[task]), job.seed)


@cache
def _executors(engines: tuple[str, ...]) -> tuple[TraceCache, ...]:
    return tuple(TraceCache(engine) for engine in engines)


def _lost(design: Design, index: int, lost: JobFailure) -> CheckResult:
    instance = design[index]
    failures = (Failure("", "", lost.reason),)
    return CheckResult(design.spec.name, index, instance.factors, instance.nuisances, failures=failures)
