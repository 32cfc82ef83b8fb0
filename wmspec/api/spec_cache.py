"""Results about spec files, cached on disk with everything that they depend on.

The result of a file depends on its text, on the libraries that it uses, on the folders of the other files that it
names, on wmspec, on Python and on the installed packages. All of these are compared before a cached result is returned.
Importing this module imports nothing of the parser or checker.
"""

from __future__ import annotations

import json
import os
import zlib
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Generic, TypeVar

from wmspec.core import disk_cache
from wmspec.core.diagnostics import Diagnostic, Note, Remedy, WmsError
from wmspec.core.places import FilePlace, Location, Place, PrimPlace, Source, Span
from wmspec.core.safe_io import Searched, read_bytes
from wmspec.lang.parse.files import find_library, read_source

if TYPE_CHECKING:
    from wmspec.lang.parse.load import Program

T = TypeVar("T")

#: Codes of mistakes that also depend on the files in a folder; results with them are not cached.
LISTING = frozenset({"WMS207", "WMS208", "WMS210"})
#: A result that depends on folders with more files or bytes than this is not cached.
MAX_FILES, MAX_BYTES = 1000, 50_000_000
#: Environment variables that name folders in which files are searched.
_SEARCH_PATHS = ("WMSPEC_PATH", "PXR_AR_DEFAULT_SEARCH_PATH")


@dataclass(frozen=True)
class Cached(Generic[T]):
    """A cached result: its `value` and diagnostics, the texts of the spec and its libraries, paths of other files."""

    value: T
    diagnostics: tuple[Diagnostic, ...]
    source: Source
    libraries: Mapping[Path, Source]
    files: frozenset[Path]


class Entry:
    """The cached result of a `kind` about the spec at `path`."""

    def __init__(self, kind: str, path: Path) -> None:
        self.path = path
        # A changed spec replaces its own entry. Messages contain the path as given, so it is part of the name.
        context = [os.environ.get(name, "") for name in _SEARCH_PATHS]
        here = "" if path.is_absolute() and not any(context) else os.getcwd()  # noqa: PTH109
        self._name = f"{kind}-{disk_cache.digest(repr((here, str(path), *context)).encode())[:32]}"

    def read(self, decode: Callable[[Any], T]) -> Cached[T] | None:
        """Return the cached result; None if anything that it depends on has changed.

        `decode` converts the JSON values. Raises WmsError if the spec cannot be read.
        """
        content = disk_cache.read(self._name)
        if content is None:
            return None
        source = read_source(self.path)
        try:
            record = json.loads(zlib.decompress(content))
            if record["made_for"] != disk_cache.fingerprint() or record["spec"] != _digest(source):
                return None
            libraries = {}
            for library, name, digest in record["libraries"]:
                libraries[Path(library)] = text = read_source(Path(library))
                if (text.name, _digest(text)) != (name, digest):
                    return None
            if any(str(find_library(name, Path(folder))) != library for name, folder, library in record["uses"]):
                return None
            if any(_state(Path(folder)) != state for folder, state in record["folders"].items()):
                return None
            sources = {text.name: text for text in (source, *libraries.values())}
            diagnostics = tuple(_diagnostic_from(d, sources) for d in record["diagnostics"])
            files = frozenset(map(Path, record["files"]))
            return Cached(decode(record["value"]), diagnostics, source, libraries, files)
        except (WmsError, zlib.error, ValueError, TypeError, KeyError, AttributeError):
            return None  # no library, or a foreign entry

    def write(self, program: Program, searched: Searched, diagnostics: Sequence[Diagnostic], value: object) -> None:
        """Store a result, as JSON values, with everything that it depends on; do nothing if that cannot be compared."""
        if any(d.code in LISTING for d in diagnostics):
            return
        sources = {program.source.name: program.source}
        sources |= {file.span.source.name: file.span.source for file in program.libraries.values()}
        if len(sources) != 1 + len(program.libraries):
            return  # two texts with the same name
        homes = {file.span.source.name: library.parent for library, file in program.libraries.items()}
        uses = {
            (span.text, str(homes.get(span.source.name, self.path.parent)), str(library))
            for span, library in program.paths.items()
        }
        folders = {str(folder): _state(folder) for folder in sorted(searched.folders)}
        if None in folders.values():
            return
        try:
            records = [_diagnostic_record(d, sources) for d in diagnostics]
        except _UncachedSource:
            return
        texts = [(path, file.span.source) for path, file in program.libraries.items()]
        record = {
            "made_for": disk_cache.fingerprint(),
            "spec": _digest(program.source),
            "uses": sorted(uses),
            "libraries": [[str(path), text.name, _digest(text)] for path, text in texts],
            "folders": folders,
            "files": sorted(map(str, searched.files)),
            "diagnostics": records,
            "value": value,
        }
        disk_cache.write(self._name, zlib.compress(json.dumps(record).encode(), 1))


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
