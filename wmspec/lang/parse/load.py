"""Loads a spec with the libraries that it uses."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cache, lru_cache
from pathlib import Path
from typing import TypeVar

from wmspec.core.diagnostics import Diagnostic, Note, Report, WmsError, suggestion
from wmspec.core.limits import LIBRARIES, LIBRARY_DEPTH, TooLarge
from wmspec.core.places import Location, Place, Source, Span
from wmspec.lang.parse import library_cache
from wmspec.lang.parse.files import find_library, library_folder, read_source, resolve_display_path, search_path
from wmspec.lang.parse.parser import parse
from wmspec.lang.parse.syntax import File, Name, Use, statements

P = TypeVar("P", Place, Place | None)


@dataclass(frozen=True)
class Program:
    """A parsed file, its direct and indirect libraries in order of use, and the library path of each `use`."""

    source: Source
    file: File
    libraries: dict[Path, File]
    paths: dict[Span, Path]

    @property
    def whole(self) -> bool:
        """Whether all files were parsed and found; if not, names may be missing."""
        files = (self.file, *self.libraries.values())
        return all(file.whole and all(use.name.span in self.paths for use in _uses(file)) for file in files)


def load(path: Path, report: Report) -> Program:
    """Read and parse the spec at `path`. Raises WmsError if the file cannot be read."""
    source = read_source(path)
    return load_source(source, path.parent, report)


def load_source(source: Source, folder: Path, report: Report) -> Program:
    """Parse a spec from text. Libraries are searched in `folder`, on WMSPEC_PATH, then among the bundled ones."""
    file, mistakes = _parsed(source)
    report.include(mistakes)
    program = Program(file.span.source, file, {}, {})  # the text that its spans refer to
    _collect(file, folder, report, program, ())
    return program


def with_source_text(diagnostics: Iterable[Diagnostic]) -> tuple[Diagnostic, ...]:
    """Return the diagnostics with source text at the locations that the IR stores, where it is still readable."""
    source = cache(_readable)

    def at(place: P) -> P | Span:
        if not isinstance(place, Location) or (text := source(place.file)) is None:
            return place
        end = len(text.text)
        return Span(text, min(place.start, end), min(place.end, end))

    return tuple(
        replace(d, place=at(d.place), notes=tuple(replace(note, place=at(note.place)) for note in d.notes))
        for d in diagnostics
    )


def _readable(name: str) -> Source | None:
    """Return the text of a file by its name in messages; None if it cannot be read, as for tasks built in Python."""
    with suppress(WmsError):
        return read_source(resolve_display_path(name))
    return None


def _uses(file: File) -> Iterator[Use]:
    return (item for item in statements(file.items) if isinstance(item, Use))


def _collect(file: File, folder: Path, report: Report, program: Program, trail: tuple[tuple[Path, Span], ...]) -> None:
    for use in _uses(file):
        path = _find(use.name, folder, report)
        if path is None:
            continue
        if any(path == p for p, _ in trail):
            notes = tuple(Note("used from here", span) for _, span in trail)
            help = "move the shared part to a third library"
            report.add("WMS208", f"`{use.name.id}` uses itself in a circle", use.span, help, notes)
            continue
        program.paths[use.name.span] = path
        for limit, count in ((LIBRARY_DEPTH, len(trail)), (LIBRARIES, len(program.libraries))):
            if count >= limit.most:
                raise TooLarge(f"the spec {limit.sentence}", use.span, limit.help)
        if path not in program.libraries:
            library, mistakes = _library(read_source(path))
            report.include(mistakes)
            _collect(library, path.parent, report, program, (*trail, (path, use.span)))
            program.libraries[path] = library


@lru_cache(maxsize=4)  # an editor requests the tree of one text several times
def _parsed(source: Source) -> tuple[File, tuple[Diagnostic, ...]]:
    """Return the syntax tree of a text and its diagnostics."""
    report = Report()
    return parse(source, report), report.diagnostics


@lru_cache(maxsize=64)
def _library(source: Source) -> tuple[File, tuple[Diagnostic, ...]]:
    """Return a library's tree and diagnostics; it is parsed once for all specs that use it."""
    if (tree := library_cache.load_cached(source)) is not None:
        return tree, ()
    tree, mistakes = _parsed(source)
    if not mistakes:
        library_cache.store(source, tree)
    return tree, mistakes


def _find(name: Name, folder: Path, report: Report) -> Path | None:
    if not name.id:  # a missing name was reported
        return None
    path = find_library(name.id, folder)
    if path is None:
        places = (folder, *search_path(), library_folder())
        known = [p.stem for place in places for p in sorted(place.glob("*.wms"))]
        report.add(
            "WMS207",
            f"there is no library `{name.id}` next to the spec, on WMSPEC_PATH or in wmspec's own",
            name.span,
            suggestion(name.id, known),
        )
    return path
