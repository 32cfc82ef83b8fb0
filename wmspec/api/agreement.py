"""Do the engines agree on the same instances?"""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any

from wmspec.api.loading import Tell, load_all, of_dimensions, warn
from wmspec.api.progress import Progress, silent
from wmspec.api.task import Task
from wmspec.core.diagnostics import WmsError
from wmspec.core.tally import Tally
from wmspec.lang.check.ir.record import to_json
from wmspec.runtime.compare.model import Checked
from wmspec.runtime.compare.record import junit, record
from wmspec.runtime.compare.summary import Doubtful, Line, Suspect, doubtful, lines, suspects
from wmspec.runtime.compare.sweep import Job, Swept, pairs, sweep
from wmspec.runtime.compare.tolerance import tolerances
from wmspec.runtime.compare.verbalize import complaints
from wmspec.runtime.engines.registry import chosen, only_here
from wmspec.runtime.workers.pool import Effort

if TYPE_CHECKING:
    import pandas as pd

#: Tasks, as they are or by the paths of specs and folders of them.
Tasks = Task | str | PathLike[str] | Iterable[Task | str | PathLike[str]]


@dataclass(frozen=True)
class Agreement:
    """What came of a crosscheck: the `instances` that were executed, each with its comparisons and verdicts.

    With `strict`, an instance passes only if its trajectories are within tolerance too. `tally` says whether anything
    was compared, and how many instances failed by an internal error, a crash or a timeout.
    """

    job: Job
    instances: tuple[Checked, ...]
    strict: bool
    tally: Tally

    @property
    def lines(self) -> tuple[Line, ...]:
        """A line for every task and pair of engines: how many answers agree, and how far bodies part."""
        return lines(self.instances, pairs(self.job.engines))

    @property
    def suspects(self) -> tuple[Suspect, ...]:
        """The values of factors with which more goes wrong than without."""
        return suspects(self.instances)

    @property
    def doubtful(self) -> tuple[Doubtful, ...]:
        """Answers that rest on motion that engines get wrong, so that their agreement is no proof."""
        return doubtful(self.instances)

    @property
    def failed(self) -> tuple[Checked, ...]:
        """The instances on which the engines do not agree, or that one cannot execute."""
        return tuple(c for c in self.instances if not c.passes(self.strict))

    def complaints(self, instance: Checked) -> list[str]:
        """What is wrong with an instance, a sentence each: where engines part, when, and what to do about it."""
        return complaints(instance, self.strict)

    @property
    def passed(self) -> bool:
        """Whether the engines agree on all of them."""
        return not self.failed

    def record(self) -> dict[str, Any]:
        """All of it as JSON values, SI units."""
        return record(self.job, self.instances, self.strict)

    def junit(self) -> str:
        """JUnit XML, as continuous integration reads it, a test case for each instance."""
        return junit(self.job, self.instances, self.strict)

    def to_pandas(self) -> pd.DataFrame:
        """The lines as a table. Raises WmsError if pandas is not installed."""
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
        tasks: a task, the path of a spec or of a folder of them, or several.
        sample: how many instances of each task.
        backend: two or more engines, joined by commas, or "all" that are installed.
        seed: what the draws depend on, of tasks that are given by their path, 0 if it is left out; a task has its own.
        tolerance: settings such as "drift=1cm/s" in place of a task's own tolerances.
        strict: whether trajectories must be within tolerance for an instance to pass.
        workers: processes, 0 to have none; one for each core if it is left out.
        timeout: seconds that an instance may take.
        progress: shows how far it has come; `wmspec.progress_bar` does.
        tell: told what is left out.

    Raises:
        WmsError: there are not two engines, or nothing that can be executed.
    """
    engines = chosen(backend)
    if len(engines) < 2:
        raise WmsError(f"a crosscheck needs two engines, and there is only {engines[0]}; try `wmspec doctor`")
    gathered_tasks = gathered(tasks, seed, tell)
    specs = [task.spec for task in gathered_tasks]
    limits = tuple((s.name, tolerances(tolerance, s.tolerances)) for s in specs)
    job = Job(tuple((s.name, to_json(s)) for s in specs), gathered_tasks[0].seed, engines, limits)
    with progress(sum(min(sample, len(task)) for task in gathered_tasks), "crosschecking") as advance:
        swept = sweep(specs, sample, job, effort(workers, timeout, engines), advance)
    return Agreement(job, swept.checked, strict, _tally(swept))


def _tally(swept: Swept) -> Tally:
    compared = sum(bool(one.comparisons) for one in swept.checked)
    cause = "" if swept.cause is None else swept.cause.crash.told() if swept.cause.crash else swept.cause.reason
    return Tally("instance was compared", compared, "instances", len(swept.checked), swept.failed, cause)


def gathered(tasks: Tasks, seed: int | None, tell: Tell, dimensions: Sequence[str] = ()) -> tuple[Task, ...]:
    """The tasks meant, of these dimensions.

    Raises WmsError if they have different seeds, or another than the `seed` that is asked for, or if there is none.
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
    return of_dimensions(loaded, dimensions)


def effort(workers: int | None, timeout: float, engines: Iterable[str]) -> Effort:
    """How hard to try: with a worker for each core if nothing is said, with none for engines of this process alone."""
    if only_here(engines):
        return Effort(0, timeout)
    return Effort((os.cpu_count() or 1) if workers is None else workers, timeout)


def _row(line: Line) -> Mapping[str, Any]:
    """A line with its shares as two columns each."""
    plain = asdict(line) | {"engines": " ".join(line.engines)}
    for name in ("answers", "before_gates", "episodes"):
        share = plain.pop(name)
        plain |= {name: share["good"], f"{name}_of": share["all"]}
    return plain
