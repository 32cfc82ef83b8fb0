"""Load and check specs: one task, all tasks of files and folders, or all diagnostics."""

from __future__ import annotations

import warnings
from base64 import b64decode, b64encode
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from os import PathLike
from pathlib import Path

from wmspec.api import spec_cache
from wmspec.api.task import Task
from wmspec.compile.design.design import Design
from wmspec.core import node_pickle
from wmspec.core.diagnostics import Diagnostic, Report, SpecError, WmsError, suggestion
from wmspec.core.places import Source
from wmspec.core.safe_io import files_searched
from wmspec.lang.check.ir import ir
from wmspec.lang.check.ir.ir import TaskSpec
from wmspec.lang.check.library.expand import APPROXIMATION
from wmspec.lang.check.statements.task import check_program
from wmspec.lang.parse.files import catalogue_folders, display_path, spec_files
from wmspec.lang.parse.load import Program, load_source
from wmspec.lang.parse.load import load as load_program

PathOrText = str | PathLike[str]

#: Receives warnings, one text at a time.
Tell = Callable[[str], None]


def warn(text: str) -> None:
    """Issue a Python warning."""
    warnings.warn(text, stacklevel=2)


def load(
    path: PathOrText | None = None, *, text: str | None = None, task: str = "", seed: int = 0, tell: Tell = warn
) -> Task:
    """Load the task of the spec at `path`, or of a `text`.

    Libraries of a text are searched in the current folder. `task` selects one of several tasks; all draws depend on
    `seed`.

    Raises:
        SpecError: the spec has mistakes; `diagnostics` lists all of them.
        WmsError: the spec cannot be read, has no task, or has several and `task` names none of them.
    """
    if (path is None) == (text is None):
        raise WmsError('give either the path of a spec or its text: `load("my.wms")` or `load(text="task ...")`')
    tasks = _tasks([_text(text)] if text is not None else [Path(path)], seed, tell)  # type: ignore[arg-type]
    names = [t.name for t in tasks]
    where = "the text" if path is None else str(path)
    if task and task not in names:
        raise WmsError(f"{where} has no task `{task}`; {suggestion(task, names)}")
    if not task and len(tasks) > 1:
        raise WmsError(f"{where} has {len(tasks)} tasks; choose one of {', '.join(names)} by name, or use `load_all`")
    return tasks[names.index(task)] if task else tasks[0]


def load_all(*paths: PathOrText, seed: int = 0, tell: Tell = warn, strict: bool = False) -> tuple[Task, ...]:
    """Load all tasks of spec files and folders, in order; without paths, the tasks of WM-ABench.

    With `strict`, content of an asset file that cannot be read exactly is an error.

    Raises:
        SpecError: specs have mistakes; `diagnostics` lists all of them.
        WmsError: a file cannot be read, there is no task, or two tasks have the same name.
    """
    return _tasks(spec_files(map(Path, paths or catalogue_folders())), seed, tell, strict)


def without_approximations(diagnostics: Iterable[Diagnostic]) -> tuple[Diagnostic, ...]:
    """Return the diagnostics, with approximations of asset files as errors."""
    return tuple(replace(d, severity="error") if d.code == APPROXIMATION else d for d in diagnostics)


@dataclass(frozen=True)
class Diagnosis:
    """The errors and warnings of specs (`diagnostics`), and the name and number of instances of each task (`tasks`).

    `designs` holds the design of each task that has one, by name. `mistaken` holds the names of the tasks whose scenes
    have mistakes.
    """

    diagnostics: tuple[Diagnostic, ...]
    tasks: tuple[tuple[str, int], ...]
    designs: Mapping[str, Design] = field(default_factory=dict, repr=False, compare=False)
    mistaken: frozenset[str] = frozenset()

    @property
    def passed(self) -> bool:
        """Whether there are no errors; warnings are allowed."""
        return not any(d.severity == "error" for d in self.diagnostics)


def diagnose(*paths: PathOrText, text: str | None = None) -> Diagnosis:
    """Check specs, their designs, and a sample of their scenes, without executing them. `text` is the text of a spec.

    Libraries and files are looked up next to a spec file; those of a `text`, in the working folder.
    Raises WmsError if a file cannot be read.
    """
    files: list[Path | Source] = [*spec_files(map(Path, paths)), *([_text(text)] if text is not None else [])]
    found = [diagnose_file(file)[0] for file in files]
    report = Report()
    for each in found:
        report.include(each.diagnostics)
    return Diagnosis(
        report.diagnostics,
        tuple(task for each in found for task in each.tasks),
        {name: design for each in found for name, design in each.designs.items()},
        frozenset[str]().union(*(each.mistaken for each in found)),
    )


def diagnose_file(file: Path | Source) -> tuple[Diagnosis, Program]:
    """Return the diagnosis of one spec and its parsed program. Raises WmsError if the file cannot be read."""
    report = Report()
    program, tasks = _load(file, 0, report)
    return _diagnosis(report, tasks, tried=True), program


class TextCheck:
    """An unsaved text of the file at `path`, parsed and checked. Raises WmsError if a library cannot be read."""

    def __init__(self, text: str, path: Path) -> None:
        self._report = Report()
        program = load_source(Source(display_path(path), text.replace("\r\n", "\n")), path.parent, self._report)
        tasks = tuple(_task(spec, program, path) for spec in check_program(program, self._report))
        self.tasks = () if self._report.failed else tasks
        """The tasks; empty if the text has mistakes."""
        self._tasks = tasks

    def diagnosis(self, *, tried: bool = True) -> Diagnosis:
        """Return the diagnosis of the text; with `tried`, a sample of its scenes is built too."""
        return _diagnosis(self._report, self._tasks, tried)


def _diagnosis(report: Report, tasks: Sequence[Task], tried: bool) -> Diagnosis:
    """Return the diagnosis of the tasks; with `tried`, a sample of their scenes is built first."""
    from wmspec.compile.lint.dry_run import dry_run

    sizes: list[tuple[str, int]] = []
    designs: dict[str, Design] = {}
    mistaken: set[str] = set()
    for task in tasks:
        own = Report()
        design = dry_run(task.spec, own) if tried else None
        report.include(own.diagnostics)
        sizes.append((task.name, 0 if design is None else len(design)))
        designs |= {} if design is None else {task.name: design}
        mistaken |= {task.name} if own.failed else set()
    return Diagnosis(report.diagnostics, tuple(sizes), designs, frozenset(mistaken))


def filter_dimensions(tasks: Sequence[Task], dimensions: Sequence[str]) -> tuple[Task, ...]:
    """Return the tasks in any of the dimensions or below; all tasks if none is given.

    Raises WmsError if a dimension has no task.
    """
    known = {task.dimension for task in tasks}
    for requested in dimensions:
        if not any(_within(dimension, requested) for dimension in known):
            parts = {d.rsplit(".", n)[0] for d in known for n in range(d.count(".") + 1)}
            raise WmsError(f"no task has the dimension `{requested}`; {suggestion(requested, parts)}".rstrip("; "))
    return tuple(t for t in tasks if not dimensions or any(_within(t.dimension, d) for d in dimensions))


def _within(dimension: str, requested: str) -> bool:
    return f"{dimension}.".startswith(f"{requested}.")


def _text(text: str) -> Source:
    return Source("<text>", text.replace("\r\n", "\n"))


def _tasks(specs: Iterable[Path | Source], seed: int, tell: Tell, strict: bool = False) -> tuple[Task, ...]:
    report = Report()
    tasks = tuple(task for spec in specs for task in _checked(spec, seed, report))
    report.stop_if_failed()
    if strict and any(d.code == APPROXIMATION for d in report.diagnostics):
        raise SpecError.of(d for d in without_approximations(report.diagnostics) if d.severity == "error")
    for diagnostic in report.diagnostics:
        tell(diagnostic.render())
    if not tasks:
        raise WmsError("there is no task in the files given; a task begins with `task NAME : DIMENSION {`")
    first: dict[str, Task] = {}
    for task in tasks:
        if task.name in first:
            there, here = first[task.name].file, task.file
            raise WmsError(f"two tasks are called `{task.name}`: in {there} and in {here}; rename one")
        first[task.name] = task
    return tasks


def _checked(spec: Path | Source, seed: int, report: Report) -> list[Task]:
    """Return the tasks of a spec; those of a file that has not changed since come from the cache."""
    entry = spec_cache.Entry("spec", spec) if isinstance(spec, Path) else None
    if entry is not None and (cached := entry.read(_specs)) is not None:
        report.include(cached.diagnostics)
        return [Task(task, cached.source, cached.libraries, entry.path, seed, cached.files) for task in cached.value]
    return _load(spec, seed, report)[1]


def _load(spec: Path | Source, seed: int, report: Report) -> tuple[Program, list[Task]]:
    """Return the parsed program and the checked tasks of a spec; the tasks of a file without mistakes are cached."""
    own = Report()  # per file, so that mistakes in one do not prevent the check of another
    with files_searched() as searched:
        program = load_program(spec, own) if isinstance(spec, Path) else load_source(spec, Path(), own)
        checked = check_program(program, own)
    report.merge(own)
    if isinstance(spec, Path) and not own.failed:
        value = b64encode(node_pickle.dumps(tuple(checked))).decode()
        spec_cache.Entry("spec", spec).write(program, searched, own.diagnostics, value)
    return program, [_task(each, program, spec, seed, frozenset(searched.files)) for each in checked]


def _specs(encoded: str) -> tuple[TaskSpec, ...]:
    """Return the checked tasks of a cache entry. Raises ValueError if it holds anything else."""
    found = node_pickle.loads(b64decode(encoded, validate=True), ir)
    if not isinstance(found, tuple) or not all(isinstance(each, TaskSpec) for each in found):
        raise ValueError("no checked tasks")
    return found


def _task(
    spec: TaskSpec, program: Program, home: Path | Source, seed: int = 0, files: frozenset[Path] = frozenset()
) -> Task:
    libraries = {path: file.span.source for path, file in program.libraries.items()}
    return Task(spec, program.source, libraries, home if isinstance(home, Path) else None, seed, files)
