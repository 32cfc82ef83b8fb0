"""`wmspec check` with its results cached: an unchanged spec is not parsed, checked and dry-run again.

Importing this module imports nothing of the parser or checker.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import astuple, dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from wmspec.api import spec_cache
from wmspec.core.diagnostics import Diagnostic, Report
from wmspec.core.places import Source
from wmspec.core.safe_io import files_searched
from wmspec.lang.parse.files import spec_files

if TYPE_CHECKING:
    from wmspec.api.loading import Diagnosis


@dataclass(frozen=True)
class CheckedTask:
    """A task of a spec: number of instances, sample sizes, balanced question, and whether it has mistakes."""

    name: str
    instances: int
    sample_sizes: Mapping[str, int] | None
    """None if the task has no design."""
    balance: str
    mistaken: bool


@dataclass(frozen=True)
class Checked:
    """The result of `wmspec check`."""

    diagnostics: tuple[Diagnostic, ...]
    tasks: tuple[CheckedTask, ...]

    @property
    def passed(self) -> bool:
        """Whether there are no errors; warnings are allowed."""
        return not any(d.severity == "error" for d in self.diagnostics)


def check_files(paths: Iterable[Path]) -> Checked:
    """Check spec files and all specs in folders. Raises WmsError if one cannot be read."""
    checked = [_checked(path) for path in spec_files(paths)]
    report = Report()
    for each in checked:
        report.include(each.diagnostics)
    return Checked(report.diagnostics, tuple(task for each in checked for task in each.tasks))


def check_text(source: Source) -> Checked:
    """Check a text, whose libraries are searched in the working folder."""
    from wmspec.api.loading import diagnose

    return _of(diagnose(text=source.text))


def _checked(path: Path) -> Checked:
    entry = spec_cache.Entry("check", path)
    if (cached := entry.read(lambda values: tuple(CheckedTask(*task) for task in values))) is not None:
        return Checked(cached.diagnostics, cached.value)
    from wmspec.api.loading import diagnose_file

    with files_searched() as searched:
        diagnosis, program = diagnose_file(path)
    checked = _of(diagnosis)
    entry.write(program, searched, checked.diagnostics, [astuple(task) for task in checked.tasks])
    return checked


def _of(diagnosis: Diagnosis) -> Checked:
    def task(name: str, instances: int) -> CheckedTask:
        design = diagnosis.designs.get(name)
        sizes = None if design is None else dict(design.sample_sizes)
        balance = "" if design is None else design.spec.plan.balance
        return CheckedTask(name, instances, sizes, balance, name in diagnosis.mistaken)

    return Checked(diagnosis.diagnostics, tuple(task(*each) for each in diagnosis.tasks))
