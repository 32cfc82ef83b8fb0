"""`wmspec check` with its results cached: an unchanged spec is not parsed, checked and dry-run again.

The result of a file depends on its text, on the libraries that it uses, on the other files that it names, on wmspec, on
Python and on the installed packages. All of these are compared before a cached result is returned. Importing this
module imports nothing of the parser or checker.
"""

from __future__ import annotations

import json
import os
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from wmspec.core import disk_cache
from wmspec.core.diagnostics import Diagnostic, Note, Remedy, Report, WmsError
from wmspec.core.places import FilePlace, Location, Place, PrimPlace, Source, Span
from wmspec.core.safe_io import files_searched, read_bytes
from wmspec.lang.parse.files import find_library, read_source, spec_files

if TYPE_CHECKING:
    from wmspec.api.loading import Diagnosis
    from wmspec.lang.parse.load import Program

#: Codes of mistakes that also depend on the files in a folder; their results are not cached.
_LISTING = frozenset({"WMS207", "WMS208", "WMS210"})
#: A result that depends on folders with more files or bytes than this is not cached.
MAX_FILES, MAX_BYTES = 1000, 50_000_000


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
    if len(checked) == 1:
        return checked[0]
    report = Report()
    for each in checked:
        report.include(each.diagnostics)
    return Checked(report.diagnostics, tuple(task for each in checked for task in each.tasks))


def check_text(source: Source) -> Checked:
    """Check a text, whose libraries are searched in the working folder."""
    from wmspec.api.loading import diagnose

    return _of(diagnose(text=source.text))


def _checked(path: Path) -> Checked:
    entry = _entry(path)
    if (cached := _cached(entry, path)) is not None:
        return cached
    from wmspec.api.loading import diagnose_file

    with files_searched() as searched:
        diagnosis, program = diagnose_file(path)
    checked = _of(diagnosis)
    if (record := _record(path, checked, program, searched.folders)) is not None:
        disk_cache.write(entry, json.dumps(record).encode())
    return checked


def _of(diagnosis: Diagnosis) -> Checked:
    def task(name: str, instances: int) -> CheckedTask:
        design = diagnosis.designs.get(name)
        sizes = None if design is None else dict(design.sample_sizes)
        balance = "" if design is None else design.spec.plan.balance
        return CheckedTask(name, instances, sizes, balance, name in diagnosis.mistaken)

    return Checked(diagnosis.diagnostics, tuple(task(*each) for each in diagnosis.tasks))


# ---------------------------------------------------------------- entries


def _entry(path: Path) -> str:
    """Return the name of the cache entry of a spec, so that a changed spec replaces its own entry.

    It depends on the path as given, since messages contain that path.
    """
    return f"check-{disk_cache.digest(repr((os.getcwd(), str(path), *_context())).encode())[:32]}.json"  # noqa: PTH109


def _context() -> tuple[str, ...]:
    return (os.environ.get("WMSPEC_PATH", ""), os.environ.get("PXR_AR_DEFAULT_SEARCH_PATH", ""))


def _record(path: Path, checked: Checked, program: Program, searched: set[Path]) -> dict[str, Any] | None:
    """Return a result with everything that it depends on, as JSON values; None if that cannot be compared."""
    if any(d.code in _LISTING for d in checked.diagnostics):
        return None
    sources = {program.source.name: program.source}
    sources |= {file.span.source.name: file.span.source for file in program.libraries.values()}
    if len(sources) != 1 + len(program.libraries):
        return None  # two texts with the same name
    homes = {file.span.source.name: library.parent for library, file in program.libraries.items()}
    uses = {
        (span.text, str(homes.get(span.source.name, path.parent)), str(library))
        for span, library in program.paths.items()
    }
    folders = {str(folder): _state(folder) for folder in sorted(searched)}
    if None in folders.values():
        return None
    try:
        diagnostics = [_diagnostic_record(d, sources) for d in checked.diagnostics]
    except _UncachedSource:
        return None
    texts = {str(library): _digest(file.span.source) for library, file in program.libraries.items()}
    return {
        "made_for": disk_cache.fingerprint(),
        "spec": _digest(program.source),
        "uses": sorted(uses),
        "libraries": texts,
        "folders": folders,
        "diagnostics": diagnostics,
        "tasks": [[t.name, t.instances, t.sample_sizes, t.balance, t.mistaken] for t in checked.tasks],
    }


def _cached(entry: str, path: Path) -> Checked | None:
    """Return the cached result of a file; None if anything that it depends on has changed."""
    content = disk_cache.read(entry)
    if content is None:
        return None
    source = read_source(path)
    try:
        record = json.loads(content)
        if record["made_for"] != disk_cache.fingerprint() or record["spec"] != _digest(source):
            return None
        sources = {source.name: source}
        for library, digest in record["libraries"].items():
            text = read_source(Path(library))
            if _digest(text) != digest:
                return None
            sources[text.name] = text
        if any(str(find_library(name, Path(folder))) != library for name, folder, library in record["uses"]):
            return None
        if any(_state(Path(folder)) != state for folder, state in record["folders"].items()):
            return None
        diagnostics = tuple(_diagnostic_from(d, sources) for d in record["diagnostics"])
        return Checked(diagnostics, tuple(CheckedTask(*task) for task in record["tasks"]))
    except (
        WmsError,
        ValueError,
        TypeError,
        KeyError,
        AttributeError,
    ):  # no library, or a foreign entry
        return None


def _digest(source: Source) -> str:
    return disk_cache.digest(source.text.encode("utf-8", "surrogatepass"))


def _state(folder: Path) -> str | None:
    """Return a digest of all files below a folder except specs; None if there are too many, or one cannot be read."""
    facts: list[tuple[str, str]] = []
    left = MAX_BYTES
    try:
        for name in _names(str(folder)):
            if Path(name).is_symlink():
                facts.append((f"{name} ->", str(Path(name).readlink())))
            if Path(name).is_file():
                left -= Path(name).stat().st_size
                if left < 0 or len(facts) > MAX_FILES:
                    return None
                facts.append((name, disk_cache.digest(read_bytes(Path(name)))))
    except OSError:
        return None
    return disk_cache.digest(repr(facts).encode("utf-8", "surrogatepass"))


def _names(folder: str) -> Iterator[str]:
    with os.scandir(folder) as entries:
        for entry in sorted(entries, key=lambda e: e.name):
            if entry.is_dir(follow_symlinks=False):
                yield from _names(entry.path)
            elif not entry.name.endswith(".wms"):
                yield entry.path


# ---------------------------------------------------------------- diagnostics as JSON


class _UncachedSource(Exception):
    """Raised if a diagnostic points into a text that the result does not depend on."""


def _diagnostic_record(d: Diagnostic, sources: Mapping[str, Source]) -> dict[str, Any]:
    help = [d.help, d.help.wrong, d.help.right] if isinstance(d.help, Remedy) else d.help
    notes = [[note.message, _place_record(note.place, sources)] for note in d.notes]
    return {
        "message": d.message,
        "place": _place_record(d.place, sources),
        "help": help,
        "code": d.code,
        "notes": notes,
        "severity": d.severity,
    }


def _diagnostic_from(record: dict[str, Any], sources: Mapping[str, Source]) -> Diagnostic:
    help = Remedy.of(*record["help"]) if isinstance(record["help"], list) else record["help"]
    notes = []
    for message, where in record["notes"]:
        place = _place_from(where, sources)
        if place is None:
            raise ValueError("a note without a place")
        notes.append(Note(message, place))
    place = _place_from(record["place"], sources)
    return Diagnostic(record["message"], place, help, record["code"], tuple(notes), record["severity"])


def _place_record(place: Place | None, sources: Mapping[str, Source]) -> list[Any] | None:
    match place:
        case Span(source=source, start=start, end=end):
            if source != sources.get(source.name):
                raise _UncachedSource
            return ["span", source.name, start, end]
        case Location():
            return ["location", place.file, place.line, place.column, place.start, place.end]
        case PrimPlace(path=path):
            return ["prim", path]
        case FilePlace():
            return ["file", place.path, place.line, place.element]
    return None


def _place_from(record: list[Any] | None, sources: Mapping[str, Source]) -> Place | None:
    match record:
        case ["span", name, start, end]:
            return Span(sources[name], start, end)
        case ["location", file, line, column, start, end]:
            return Location(file=file, line=line, column=column, start=start, end=end)
        case ["prim", path]:
            return PrimPlace(path)
        case ["file", path, line, element]:
            return FilePlace(path, line, element)
    return None
