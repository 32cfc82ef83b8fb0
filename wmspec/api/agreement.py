"""Compare engines on the same instances."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any

from wmspec.api.loading import Tell, filter_dimensions, load_all, warn
from wmspec.api.progress import Progress, silent
from wmspec.api.task import Task
from wmspec.core.diagnostics import WmsError
from wmspec.core.tally import Tally
from wmspec.lang.check.ir.record import to_json
from wmspec.runtime.compare.model import CheckResult
from wmspec.runtime.compare.record import junit, record
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
from wmspec.runtime.compare.verbalize import complaints
from wmspec.runtime.engines.registry import is_process_local, select_backends
from wmspec.runtime.workers.pool import PoolConfig

if TYPE_CHECKING:
    import pandas as pd

#: Tasks, or paths of spec files and folders.
Tasks = Task | str | PathLike[str] | Iterable[Task | str | PathLike[str]]


@dataclass(frozen=True)
class Agreement:
    """The result of a crosscheck: the executed `instances`, each with its comparisons and verdicts.

    With `strict`, an instance passes only if its trajectories are within tolerance too. `tally` counts the compared
    instances and the instances that failed by an internal error, a crash or a timeout.
    """

    job: SweepConfig
    instances: tuple[CheckResult, ...]
    strict: bool
    tally: Tally

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

    @property
    def failed(self) -> tuple[CheckResult, ...]:
        """The instances on which engines disagree, or that an engine cannot execute."""
        return tuple(c for c in self.instances if not c.passes(self.strict))

    def complaints(self, instance: CheckResult) -> list[str]:
        """Return the failures of an instance, one sentence each: where and when engines differ, and the remedy."""
        return complaints(instance, self.strict)

    @property
    def passed(self) -> bool:
        """Whether the engines agree on all instances."""
        return not self.failed

    def record(self) -> dict[str, Any]:
        """Return all results as JSON values, in SI units."""
        return record(self.job, self.instances, self.strict)

    def junit(self) -> str:
        """Return JUnit XML for continuous integration, with one test case per instance."""
        return junit(self.job, self.instances, self.strict)

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
    workers: int | None = None,
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
        workers: number of processes; 0 runs in this one. One per core by default.
        timeout: time limit per instance, in seconds.
        progress: shows the progress, such as `wmspec.progress_bar`.
        tell: receives warnings.

    Raises:
        WmsError: fewer than two engines are installed, or there are no tasks.
    """
    engines = select_backends(backend)
    if len(engines) < 2:
        raise WmsError(f"a crosscheck needs two engines, found only {engines[0]}; try `wmspec doctor`")
    gathered_tasks = collect_tasks(tasks, seed, tell)
    specs = [task.spec for task in gathered_tasks]
    limits = tuple((s.name, tolerances(tolerance, s.tolerances)) for s in specs)
    job = SweepConfig(tuple((s.name, to_json(s)) for s in specs), gathered_tasks[0].seed, engines, limits)
    with progress(sum(min(sample, len(task)) for task in gathered_tasks), "crosschecking") as advance:
        swept = sweep(specs, sample, job, worker_settings(workers, timeout, engines), advance)
    return Agreement(job, swept.checked, strict, _tally(swept))


def _tally(swept: Swept) -> Tally:
    compared = sum(bool(one.comparisons) for one in swept.checked)
    cause = "" if swept.cause is None else swept.cause.crash.report() if swept.cause.crash else swept.cause.reason
    return Tally("instance was compared", compared, "instances", len(swept.checked), swept.failed, cause)


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
