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
from wmspec.core.safe_io import folders_searched
from wmspec.lang.parse.files import found, read_source, spec_files

if TYPE_CHECKING:
    from wmspec.api.loading import Diagnosis
    from wmspec.lang.parse.load import Program

#: Codes of mistakes that depend on more than is compared, such as on what else there is in a folder: not cached.
_LISTING = frozenset({"WMS207", "WMS208", "WMS210"})
#: If a spec names other files, all files in its folder count, up to so many and so many bytes; with more, not cached.
MOST_FILES, MOST_BYTES = 1000, 50_000_000


@dataclass(frozen=True)
class CheckedTask:
    """A task of a spec: how many instances it has, its sample sizes, the question that it balances, if it is wrong."""

    name: str
    instances: int
    sample_sizes: Mapping[str, int] | None
    """None if the task has no design."""
    balance: str
    mistaken: bool


@dataclass(frozen=True)
class Checked:
    """What `wmspec check` says of specs."""

    diagnostics: tuple[Diagnostic, ...]
    tasks: tuple[CheckedTask, ...]

    @property
    def passed(self) -> bool:
        """Whether there is no mistake; warnings are none."""
        return not any(d.severity == "error" for d in self.diagnostics)


def check_files(paths: Iterable[Path]) -> Checked:
    """What is wrong with spec files, and with all specs in folders. Raises WmsError if one cannot be read."""
    checked = [_checked(path) for path in spec_files(paths)]
    if len(checked) == 1:
        return checked[0]
    report = Report()
    for each in checked:
        report.include(each.diagnostics)
    return Checked(report.diagnostics, tuple(task for each in checked for task in each.tasks))


def check_text(source: Source) -> Checked:
    """What is wrong with a text, whose libraries are looked for in the working folder."""
    from wmspec.api.loading import diagnose

    return _of(diagnose(text=source.text))


def _checked(path: Path) -> Checked:
    entry = _entry(path)
    if (cached := _cached(entry, path)) is not None:
        return cached
    from wmspec.api.loading import diagnosed

    with folders_searched() as searched:
        diagnosis, program = diagnosed(path)
    checked = _of(diagnosis)
    if (record := _record(path, checked, program, searched)) is not None:
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
    """One entry for each spec, so that a spec that changes replaces its own. Messages show the path as it was given."""
    return f"check-{disk_cache.digest(repr((os.getcwd(), str(path), *_context())).encode())[:32]}.json"  # noqa: PTH109


def _context() -> tuple[str, ...]:
    return (os.environ.get("WMSPEC_PATH", ""), os.environ.get("PXR_AR_DEFAULT_SEARCH_PATH", ""))


def _record(path: Path, checked: Checked, program: Program, searched: set[Path]) -> dict[str, Any] | None:
    """What is kept of a result, with all that it depends on; None if that cannot be compared."""
    if any(d.code in _LISTING for d in checked.diagnostics):
        return None
    sources = {program.source.name: program.source}
    sources |= {file.span.source.name: file.span.source for file in program.libraries.values()}
    if len(sources) != 1 + len(program.libraries):
        return None  # two texts of one name
    homes = {file.span.source.name: library.parent for library, file in program.libraries.items()}
    uses = {
        (span.text, str(homes.get(span.source.name, path.parent)), str(library))
        for span, library in program.paths.items()
    }
    folders = {str(folder): _state(folder) for folder in sorted(searched)}
    if None in folders.values():
        return None
    try:
        diagnostics = [_written(d, sources) for d in checked.diagnostics]
    except _Elsewhere:
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
    """The result that is kept for a file, if nothing that it depends on has changed."""
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
        if any(str(found(name, Path(folder))) != library for name, folder, library in record["uses"]):
            return None
        if any(_state(Path(folder)) != state for folder, state in record["folders"].items()):
            return None
        diagnostics = tuple(_read(d, sources) for d in record["diagnostics"])
        return Checked(diagnostics, tuple(CheckedTask(*task) for task in record["tasks"]))
    except (WmsError, ValueError, TypeError, KeyError, AttributeError):  # a library is gone; or another wrote the entry
        return None


def _digest(source: Source) -> str:
    return disk_cache.digest(source.text.encode("utf-8", "surrogatepass"))


def _state(folder: Path) -> str | None:
    """A digest of all files in a folder and below it but specs; None if there are too many, or one cannot be read."""
    facts: list[tuple[str, str]] = []
    left = MOST_BYTES
    try:
        for name in _names(str(folder)):
            if Path(name).is_symlink():
                facts.append((f"{name} ->", str(Path(name).readlink())))
            if Path(name).is_file():
                left -= Path(name).stat().st_size
                if left < 0 or len(facts) > MOST_FILES:
                    return None
                facts.append((name, disk_cache.digest(Path(name).read_bytes())))
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


class _Elsewhere(Exception):
    """A diagnostic points into a text that the result does not depend on."""


def _written(d: Diagnostic, sources: Mapping[str, Source]) -> dict[str, Any]:
    help = [d.help, d.help.wrong, d.help.right] if isinstance(d.help, Remedy) else d.help
    notes = [[note.message, _place(note.place, sources)] for note in d.notes]
    return {
        "message": d.message,
        "place": _place(d.place, sources),
        "help": help,
        "code": d.code,
        "notes": notes,
        "severity": d.severity,
    }


def _read(record: dict[str, Any], sources: Mapping[str, Source]) -> Diagnostic:
    help = Remedy.of(*record["help"]) if isinstance(record["help"], list) else record["help"]
    notes = []
    for message, where in record["notes"]:
        place = _placed(where, sources)
        if place is None:
            raise ValueError("a note without a place")
        notes.append(Note(message, place))
    place = _placed(record["place"], sources)
    return Diagnostic(record["message"], place, help, record["code"], tuple(notes), record["severity"])


def _place(place: Place | None, sources: Mapping[str, Source]) -> list[Any] | None:
    match place:
        case Span(source=source, start=start, end=end):
            if source != sources.get(source.name):
                raise _Elsewhere
            return ["span", source.name, start, end]
        case Location():
            return ["location", place.file, place.line, place.column, place.start, place.end]
        case PrimPlace(path=path):
            return ["prim", path]
        case FilePlace():
            return ["file", place.path, place.line, place.element]
    return None


def _placed(record: list[Any] | None, sources: Mapping[str, Source]) -> Place | None:
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
