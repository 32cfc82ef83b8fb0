"""Compare engines on the same instances."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from functools import cached_property
from os import PathLike
from pathlib import Path
from time import monotonic
from typing import TYPE_CHECKING, Any

from wmspec.api.changes import changed_tasks
from wmspec.api.loading import Tell, filter_dimensions, load_all, warn
from wmspec.api.progress import Progress, silent
from wmspec.api.task import Task
from wmspec.core import disk_cache
from wmspec.core.diagnostics import WmsError
from wmspec.core.tally import Tally
from wmspec.lang.check.ir.record import to_json
from wmspec.runtime.compare.baseline import Baseline, read_baseline
from wmspec.runtime.compare.disagreement import Disagreement, complaints, disagreements
from wmspec.runtime.compare.model import CheckResult
from wmspec.runtime.compare.record import junit, record
from wmspec.runtime.compare.result_cache import ResultCache
from wmspec.runtime.compare.summary import (
    Suspect,
    TaskAgreement,
    UnreliableAnswers,
    lines,
    suspects,
    unreliable_answers,
)
from wmspec.runtime.compare.sweep import SweepConfig, Swept, pairs, sweep
from wmspec.runtime.compare.tolerance import tolerances
from wmspec.runtime.engines.registry import is_process_local, select_backends
from wmspec.runtime.workers.pool import PoolConfig, Workers

if TYPE_CHECKING:
    import pandas as pd

#: Tasks, or paths of spec files and folders.
Tasks = Task | str | PathLike[str] | Iterable[Task | str | PathLike[str]]


@dataclass(frozen=True)
class Agreement:
    """The result of a crosscheck: the executed `instances`, each with its comparisons and verdicts.

    With `strict`, an instance passes only if its trajectories are within tolerance too. Disagreements in `baseline`
    are known and accepted. The crosscheck passes if at least `fail_under` percent of the instances pass or have
    known disagreements only. `planned` counts all instances of the sample, also those that were not executed because
    time ran out; `cached` counts those whose results came from the cache. `tally` counts the compared instances, and
    the instances that failed by an internal error, a crash or a timeout.
    """

    job: SweepConfig
    instances: tuple[CheckResult, ...]
    strict: bool
    tally: Tally
    planned: int = 0
    cached: int = 0
    refused: int = 0
    """Cache entries that were damaged or not trusted."""
    lost: frozenset[tuple[str, int]] = frozenset()
    """Task and index of the instances that failed by an internal error, a crash or a timeout."""
    baseline: Baseline = field(default_factory=lambda: Baseline(0))
    fail_under: float = 100.0
    tasks: tuple[Task, ...] = field(default=(), repr=False, compare=False)

    @property
    def lines(self) -> tuple[TaskAgreement, ...]:
        """One line per task and pair of engines: how many answers agree, and how far bodies diverge."""
        return lines(self.instances, pairs(self.job.engines))

    @property
    def suspects(self) -> tuple[Suspect, ...]:
        """Levels of factors with more disagreements than elsewhere."""
        return suspects(self.instances)

    @property
    def unreliable_answers(self) -> tuple[UnreliableAnswers, ...]:
        """Answers that depend on motion that engines simulate wrongly; their agreement proves nothing."""
        return unreliable_answers(self.instances)

    @cached_property
    def disagreements(self) -> tuple[Disagreement, ...]:
        """All disagreements, known and new."""
        return tuple(d for c in self.instances for d in disagreements(c, self.strict))

    @cached_property
    def new(self) -> tuple[Disagreement, ...]:
        """The disagreements that are not in the baseline."""
        known = self.baseline.identities
        return tuple(d for d in self.disagreements if d.identity not in known or (d.task, d.index) in self.lost)

    @property
    def vanished(self) -> tuple[Disagreement, ...]:
        """The disagreements of the baseline that did not occur again when this crosscheck executed their instances."""
        return self.baseline.vanished(self.disagreements, self.job, self.instances)

    @property
    def updated_baseline(self) -> Baseline:
        """The baseline with the current disagreements and without those that vanished."""
        lasting = [d for d in self.disagreements if (d.task, d.index) not in self.lost]
        return self.baseline.updated(lasting, self.vanished)

    @property
    def failed(self) -> tuple[CheckResult, ...]:
        """The instances with disagreements outside the baseline, including failures of an engine."""
        wrong = {(d.task, d.index) for d in self.new}
        return tuple(c for c in self.instances if (c.task, c.index) in wrong)

    def complaints(self, instance: CheckResult) -> list[str]:
        """Return the failures of an instance, one sentence each: where and when engines differ, and the remedy."""
        return complaints(instance, self.strict)

    @property
    def share(self) -> float:
        """The percentage of instances that pass or have known disagreements only; 100 without instances."""
        count = len(self.instances)
        return 100.0 * (count - len(self.failed)) / count if count else 100.0

    @property
    def passed(self) -> bool:
        """Whether the share of instances that pass is large enough."""
        return self.share >= self.fail_under

    def record(self) -> dict[str, Any]:
        """Return all results as JSON values, in SI units."""
        known = record(self.job, self.instances, self.strict, {(d.task, d.index) for d in self.new})
        return known | {"passes": self.passed, "planned": self.planned, "vanished": [asdict(d) for d in self.vanished]}

    def junit(self) -> str:
        """Return JUnit XML with one test case per instance, skipped if its disagreements are known."""
        return junit(self.job, self.instances, self.strict, {(d.task, d.index) for d in self.new})

    def to_pandas(self) -> pd.DataFrame:
        """Return the lines as a table. Raises WmsError if pandas is not installed."""
        try:
            import pandas as pd
        except ImportError:
            raise WmsError("a table needs pandas; install it with `pip install pandas`, or use `lines`") from None
        return pd.DataFrame([_row(line) for line in self.lines])


def crosscheck(
    tasks: Tasks,
    *,
    sample: int = 20,
    backend: str = "all",
    seed: int | None = None,
    tolerance: Iterable[str] = (),
    strict: bool = False,
    changed_since: str = "",
    baseline: str | PathLike[str] | Baseline | None = None,
    fail_under: float = 100.0,
    max_time: float | None = None,
    cache: bool | str | PathLike[str] = True,
    workers: int | Callable[[], Workers] | None = None,
    timeout: float = 300.0,
    progress: Progress = silent,
    tell: Tell = warn,
) -> Agreement:
    """Execute `sample` random instances of each task in several engines and compare trajectories, events and answers.

    Args:
        tasks: a task, the path of a spec or of a folder of specs, or several of these.
        sample: number of instances per task.
        backend: two or more engines, separated by commas, or "all" installed ones.
        seed: random seed of tasks given by path, 0 by default; a loaded task has its own.
        tolerance: settings such as "drift=1cm/s" that override the tolerances of a task.
        strict: whether trajectories must be within tolerance for an instance to pass.
        changed_since: a git revision; only tasks whose files have changed since HEAD branched from it are executed.
        baseline: known disagreements, or the file that holds them.
        fail_under: percentage of instances that must pass.
        max_time: time (s) after which no group of instances begins. If it is set, groups of all tasks alternate.
        cache: whether results are kept in the user's cache; or another folder for them.
        workers: number of processes (default: one per core; 0: this process), or a function that returns `Workers`.
        timeout: time limit per instance, in seconds.
        progress: shows the progress, such as `wmspec.progress_bar`.
        tell: receives warnings.

    Raises:
        WmsError: fewer than two engines are installed, there are no tasks, git or the baseline cannot be read.
    """
    deadline = None if max_time is None else monotonic() + max_time
    engines = select_backends(backend)
    if len(engines) < 2:
        raise WmsError(f"a crosscheck needs two engines, found only {engines[0]}; try `wmspec doctor`")
    every = collect_tasks(tasks, seed, tell)
    known = baseline if isinstance(baseline, Baseline) else _baseline(baseline, every[0].seed)
    chosen = changed_tasks(every, changed_since) if changed_since else every
    specs = [task.spec for task in chosen]
    limits = tuple((s.name, tolerances(tolerance, s.tolerances)) for s in specs)
    job = SweepConfig(tuple((s.name, to_json(s)) for s in specs), every[0].seed, engines, limits)
    results = _cache(cache, job, chosen)
    with progress(sum(len(task.design.sample(sample)) for task in chosen), "crosschecking") as advance:
        settings = PoolConfig(1, timeout, workers) if callable(workers) else worker_settings(workers, timeout, engines)
        swept = sweep(specs, sample, job, settings, advance, results, deadline)
    return Agreement(
        job=job,
        instances=swept.checked,
        strict=strict,
        tally=_tally(swept),
        planned=swept.planned,
        cached=swept.cached,
        refused=results.refused if results else 0,
        lost=swept.lost,
        baseline=known,
        fail_under=fail_under,
        tasks=chosen,
    )


def _baseline(path: str | PathLike[str] | None, seed: int) -> Baseline:
    return Baseline(seed) if path is None else read_baseline(Path(path), seed)


def _cache(choice: bool | str | PathLike[str], job: SweepConfig, tasks: Iterable[Task]) -> ResultCache | None:
    """Return the cache of results; None if it is off, or an engine exists in this process only."""
    if choice is False or is_process_local(job.engines):
        return None
    folder = disk_cache.folder() if choice is True else Path(choice)
    return ResultCache(folder / "crosscheck", job, {task.name: task.assets for task in tasks})


def _tally(swept: Swept) -> Tally:
    compared = sum(bool(one.comparisons) for one in swept.checked)
    cause = "" if swept.cause is None else swept.cause.crash.report() if swept.cause.crash else swept.cause.reason
    return Tally("instance was compared", compared, "instances", len(swept.checked), len(swept.lost), cause)


def collect_tasks(tasks: Tasks, seed: int | None, tell: Tell, dimensions: Sequence[str] = ()) -> tuple[Task, ...]:
    """Return the given tasks, restricted to these dimensions.

    Raises WmsError if there is none, or if their seeds differ from one another or from `seed`.
    """
    given = [tasks] if isinstance(tasks, Task | str | PathLike) else list(tasks)
    paths = [Path(spec) for spec in given if not isinstance(spec, Task)]
    loaded = [spec for spec in given if isinstance(spec, Task)]
    if paths:
        loaded += load_all(*paths, seed=seed or 0, tell=tell)
    seeds = {task.seed for task in loaded}
    if len(seeds) > 1:
        raise WmsError(f"these tasks have different seeds, {sorted(seeds)}; load them with one")
    if seed is not None and seeds - {seed}:
        raise WmsError(f"these tasks were loaded with the seed {seeds.pop()}, not {seed}; load them with `seed={seed}`")
    return filter_dimensions(loaded, dimensions)


def worker_settings(workers: int | None, timeout: float, engines: Iterable[str]) -> PoolConfig:
    """Return the worker settings: one worker per core by default, none for engines that exist in this process only."""
    if is_process_local(engines):
        return PoolConfig(0, timeout)
    return PoolConfig((os.cpu_count() or 1) if workers is None else workers, timeout)


def _row(line: TaskAgreement) -> Mapping[str, Any]:
    """Return a line as columns; each share becomes two."""
    plain = asdict(line) | {"engines": " ".join(line.engines)}
    for name in ("answers", "before_gates", "episodes"):
        share = plain.pop(name)
        plain |= {name: share["good"], f"{name}_of": share["all"]}
    return plain
