"""Checks many instances of many tasks, from the cache or in worker processes."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import closing
from dataclasses import dataclass, field, replace
from functools import cache, lru_cache
from itertools import combinations, zip_longest
from time import monotonic
from typing import Protocol

from wmspec.compile.design.design import Design
from wmspec.lang.check.ir.ir import TaskSpec
from wmspec.lang.check.ir.record import from_json
from wmspec.runtime.caches.trace_cache import TraceCache
from wmspec.runtime.compare.check import check
from wmspec.runtime.compare.model import CheckResult, Failure, Pair
from wmspec.runtime.compare.tolerance import Tolerances
from wmspec.runtime.workers.pool import JobFailure, Piece, PoolConfig, map_batches


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


class Cache(Protocol):
    """Results of earlier crosschecks."""

    def find(self, task: str, index: int) -> CheckResult | None:
        """Return the result of an instance, or None."""

    def keep(self, result: CheckResult) -> None:
        """Store a result."""


@dataclass(frozen=True)
class Swept:
    """The `checked` instances of `planned` ones, ordered by task and index.

    `lost` are the tasks and indices of those that failed before anything was compared, `cause` is the first failure.
    `cached` counts the results of earlier crosschecks.
    """

    checked: tuple[CheckResult, ...]
    planned: int = 0
    cached: int = 0
    lost: frozenset[tuple[str, int]] = frozenset()
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
    cache: Cache | None = None,
    deadline: float | None = None,
) -> Swept:
    """Return the checks of `sample` random instances per task.

    `progress` is called with a task and a number of finished instances. After the `deadline` (of the monotonic clock),
    no further group of instances begins; groups begin in the same order each time, one of each task in turn.
    """
    return _Sweep({spec.name: Design(spec, job.seed) for spec in specs}, job, cache, deadline).run(
        sample, effort, progress
    )


@dataclass
class _Sweep:
    designs: dict[str, Design]
    job: SweepConfig
    cache: Cache | None
    deadline: float | None
    results: dict[tuple[str, int], CheckResult] = field(default_factory=dict)
    failures: dict[tuple[str, int], JobFailure] = field(default_factory=dict)
    cached: int = 0

    def run(self, sample: int, effort: PoolConfig, progress: Callable[[str, int], None]) -> Swept:
        parts = {name: list(_parts(design, sample)) for name, design in self.designs.items()}
        own = {name: self.job.of(name) for name in parts}
        units = self._units(_in_turn(parts) if self.deadline is not None else _by_task(parts), own, progress)
        with closing(map_batches(work, units, effort)) as outcomes:
            for (_, name, index), outcome in outcomes:
                self._take(name, index, outcome)
                progress(name, 1)
        order = [(name, index) for name in parts for index in sorted(i for part in parts[name] for i in part)]
        failed = [self.failures[key] for key in order if key in self.failures]
        return Swept(
            checked=tuple(self.results[key] for key in order if key in self.results),
            planned=len(order),
            cached=self.cached,
            lost=frozenset(self.failures),
            cause=next((one for one in failed if one.crash), failed[0] if failed else None),
        )

    def _units(
        self,
        parts: Iterator[tuple[str, tuple[int, ...]]],
        own: dict[str, SweepConfig],
        progress: Callable[[str, int], None],
    ) -> Iterator[list[Piece]]:
        """Yield the instances to execute, a group at a time; a worker shares physics between those of a group."""
        for name, part in parts:
            if self.deadline is not None and monotonic() > self.deadline:
                return
            todo = []
            for index in part:
                known = self.cache.find(name, index) if self.cache else None
                if known is None:
                    todo.append((own[name], name, index))
                else:
                    self.results[name, index] = known
                    self.cached += 1
                    progress(name, 1)
            if todo:
                yield todo

    def _take(self, name: str, index: int, outcome: CheckResult | JobFailure) -> None:
        if isinstance(outcome, JobFailure):
            self.failures[name, index] = outcome
            outcome = _lost(self.designs[name], index, outcome)
        elif self.cache:
            self.cache.keep(outcome)
        self.results[name, index] = outcome


def _parts(design: Design, sample: int) -> Iterator[tuple[int, ...]]:
    """Yield the sampled instances, in groups."""
    part: list[int] = []
    for index in design.sample(sample):
        if part and design.sample_part(index)[0] != design.sample_part(part[0])[0]:
            yield tuple(part)
            part = []
        part.append(index)
    if part:
        yield tuple(part)


def _by_task(parts: dict[str, list[tuple[int, ...]]]) -> Iterator[tuple[str, tuple[int, ...]]]:
    return ((name, part) for name in parts for part in parts[name])


def _in_turn(parts: dict[str, list[tuple[int, ...]]]) -> Iterator[tuple[str, tuple[int, ...]]]:
    """Yield one group of each task, then a second one of each, and so on."""
    for turn in zip_longest(*parts.values()):
        yield from ((name, part) for name, part in zip(parts, turn, strict=True) if part)


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
