"""A plugin of pytest: `pytest --wmspec specs/` checks and crosschecks specs, one test per task and check.

A file has the test `check`, and each of its tasks a test `crosscheck`. Importing this module imports nothing heavy:
pytest imports it wherever wmspec is installed.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

if TYPE_CHECKING:
    from wmspec.api import Agreement
    from wmspec.runtime.workers.pool import PersistentWorkers

_WORKERS = pytest.StashKey["PersistentWorkers"]()


def pytest_addoption(parser: pytest.Parser) -> None:
    """Add the options."""
    group = parser.getgroup("wmspec", "wmspec")
    group.addoption("--wmspec", action="store_true", help="Check and crosscheck the .wms files of folders.")
    group.addoption("--wmspec-sample", type=int, default=20, metavar="N", help="Instances per task.  [default: 20]")
    group.addoption("--wmspec-backends", default="all", metavar="NAMES", help="Engines to compare.  [default: all]")
    group.addoption("--wmspec-strict", action="store_true", help="Also fail if trajectories diverge.")
    group.addoption("--wmspec-baseline", metavar="FILE", help="Known disagreements, which do not fail.")
    group.addoption("--wmspec-cache", metavar="DIR", help="Folder of results.  [default: the user's cache]")


def pytest_collect_file(file_path: Path, parent: pytest.Collector) -> SpecFile | None:
    """Collect a spec."""
    if file_path.suffix == ".wms" and parent.config.getoption("--wmspec"):
        return SpecFile.from_parent(parent, path=file_path)
    return None


def pytest_unconfigure(config: pytest.Config) -> None:
    """Stop the worker."""
    if (workers := config.stash.get(_WORKERS, None)) is not None:
        workers.close()


class SpecFile(pytest.File):
    """A spec or a library."""

    def collect(self) -> Iterator[pytest.Item | pytest.Collector]:
        """Yield the check of the file, and its tasks; none if the text cannot be parsed."""
        yield CheckItem.from_parent(self, name="check")
        for task in _task_names(self.path):
            yield SpecTask.from_parent(self, name=task)


class SpecTask(pytest.Collector):
    """A task of a spec."""

    def collect(self) -> Iterator[pytest.Item]:
        """Yield the crosscheck."""
        yield CrosscheckItem.from_parent(self, name="crosscheck")


class _SpecItem(pytest.Item):
    def repr_failure(self, excinfo: pytest.ExceptionInfo[BaseException], *arguments: Any) -> Any:
        """Return mistakes and disagreements as wmspec prints them."""
        from wmspec.core.diagnostics import WmsError
        from wmspec.lang.parse.load import with_source_text

        if isinstance(excinfo.value, _Failed):
            return str(excinfo.value)
        if isinstance(excinfo.value, WmsError):
            return WmsError.of(with_source_text(excinfo.value.diagnostics)).render()
        return super().repr_failure(excinfo, *arguments)

    def reportinfo(self) -> tuple[Path, int, str]:
        """Return the file and the name of the test."""
        names = [node.name for node in self.listchain() if isinstance(node, SpecTask | _SpecItem)]
        return self.path, 0, "::".join(names)


class CheckItem(_SpecItem):
    """`wmspec check` of a file."""

    def runtest(self) -> None:
        """Check the file. Warnings become a section of the report."""
        from wmspec.api.checking import check_files

        checked = check_files([_shown(self.path)])
        text = "\n\n".join(diagnostic.render() for diagnostic in checked.diagnostics)
        if not checked.passed:
            raise _Failed(text)
        if text:
            self.add_report_section("call", "wmspec check", text)


class CrosscheckItem(_SpecItem):
    """`wmspec crosscheck` of a task."""

    def runtest(self) -> None:
        """Compare the engines. Known disagreements become a section of the report."""
        from wmspec.api import crosscheck, load_all

        assert self.parent is not None
        option = self.config.getoption
        (task,) = (t for t in load_all(_shown(self.path), tell=lambda _: None) if t.name == self.parent.name)
        agreement = crosscheck(
            task,
            sample=option("--wmspec-sample"),
            backend=option("--wmspec-backends"),
            strict=option("--wmspec-strict"),
            baseline=option("--wmspec-baseline"),
            cache=option("--wmspec-cache") or True,
            workers=lambda: _workers(self.config),
        )
        if agreement.failed or not agreement.tally.passed:
            raise _Failed(_explained(agreement))
        if agreement.disagreements or agreement.vanished:
            self.add_report_section("call", "wmspec crosscheck", _explained(agreement))


class _Failed(Exception):
    """A spec does not pass; the message is the report."""


def _explained(agreement: Agreement) -> str:
    wrong = {(c.task, c.index) for c in agreement.failed}
    lines = [agreement.tally.message] if agreement.tally.message else []
    for instance in agreement.instances:
        if complaints := agreement.complaints(instance):
            known = "" if (instance.task, instance.index) in wrong else ", known"
            lines.append(f"{instance.task}, instance {instance.index}{known}")
            lines += [f"  {complaint}" for complaint in complaints]
    lines += [f"no longer found: {d.task}, instance {d.index}: {d.reason}" for d in agreement.vanished]
    count = len(agreement.instances)
    return "\n".join([*lines, f"{count - len(wrong)} of {count} instances pass"])


def _task_names(path: Path) -> list[str]:
    """Return the names of the tasks of a file; none if it cannot be parsed, which its check reports."""
    from wmspec.core.diagnostics import Report, WmsError
    from wmspec.lang.parse.load import load
    from wmspec.lang.parse.syntax import Task, Variant

    report = Report()
    try:
        program = load(path, report)
    except WmsError:
        return []
    names = dict[str, None]()
    for task in (item for item in program.file.items if isinstance(item, Task)):
        variants = [item.name.id for item in task.body if isinstance(item, Variant)]
        names |= dict.fromkeys([f"{task.name.id}_{variant}" for variant in variants] or [task.name.id])
    return [] if report.failed else list(names)


def _shown(path: Path) -> Path:
    """Return the path for messages: relative to the working folder, if it is below."""
    return path.relative_to(Path.cwd()) if path.is_relative_to(Path.cwd()) else path


def _workers(config: pytest.Config) -> PersistentWorkers:
    """Return the process that executes episodes, so that an engine that crashes does not end pytest."""
    from wmspec.runtime.workers.pool import PersistentWorkers

    if _WORKERS not in config.stash:
        config.stash[_WORKERS] = PersistentWorkers()
    return config.stash[_WORKERS]
