"""Reading a spec with the libraries that it uses."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path
from typing import TypeVar

from wmspec.core.diagnostics import Diagnostic, Note, Report, WmsError, suggestion
from wmspec.core.limits import MARKUP
from wmspec.core.places import FilePlace, Location, Place, Source, Span
from wmspec.core.resources import resource
from wmspec.core.safe_io import inside, plain, read_plain
from wmspec.lang.parse.parser import parse
from wmspec.lang.parse.syntax import File, Name, Statement, Task, Use, Variant

P = TypeVar("P", Place, Place | None)

#: A longer file is refused: no hand writes it.
MAX_CHARACTERS = 1_000_000


@dataclass(frozen=True)
class Program:
    """A parsed file, the libraries that it uses, directly or not, in order of use, and which library a name means."""

    source: Source
    file: File
    libraries: dict[Path, File]
    paths: dict[Span, Path]

    @property
    def whole(self) -> bool:
        """Whether all was read and found; if not, names may be missing."""
        files = (self.file, *self.libraries.values())
        return all(file.whole and all(use.name.span in self.paths for use in _uses(file.items)) for file in files)


def load(path: Path, report: Report) -> Program:
    """Read and parse the spec at `path`. Raises WmsError if there is no such readable file."""
    source = read_source(path)
    return load_source(source, path.parent, report)


def load_source(source: Source, folder: Path, report: Report) -> Program:
    """Parse a spec from text. Libraries are looked for in `folder`, on WMSPEC_PATH, then in wmspec's own."""
    file = parse(source, report)
    program = Program(source, file, {}, {})
    _collect(file, folder, report, program, ())
    return program


def read_source(path: Path) -> Source:
    """The text of a file. Raises WmsError with the reason if it cannot be read, or is a USD stage."""
    try:
        with plain(path).open("rb") as file:
            if file.read(8).startswith(_STAGE):
                raise WmsError("it is a USD stage, not a spec", FilePlace(str(path)), _run(path))
        text = read_plain(path, MARKUP).decode("utf-8-sig").replace("\r\n", "\n").replace("\r", "\n")
    except UnicodeDecodeError as error:
        raise WmsError(
            f"not UTF-8 text (byte {error.start})", FilePlace(str(path)), "a .wms file is plain UTF-8 text"
        ) from None
    except OSError as error:
        raise WmsError(f"cannot be read: {error.strerror}", FilePlace(str(path))) from None
    if len(text) > MAX_CHARACTERS:
        raise WmsError(
            f"longer than {MAX_CHARACTERS:,} characters",
            FilePlace(str(path)),
            "a spec is written by hand: is this the right file?",
        )
    return Source(shown(path), text)


#: How USD's own files begin, as text and as binary.
_STAGE = (b"#usda", b"PXR-USDC")


def _run(path: Path) -> str:
    """What to do with a stage."""
    if path.suffix:
        return f"`wmspec run {path} --for 2s` executes it"
    return f"let its name end in .usd, and `wmspec run {path}.usd --for 2s` executes it"


def shown(path: Path) -> str:
    """How a path is told: as it was given, but the libraries that come with wmspec as `<library>/tabletop.wms`."""
    if path.parent == library_folder().resolve():
        return f"<library>/{path.name}"
    return str(path)


def located(name: str) -> Path:
    """The file that was told as `name`."""
    return library_folder() / name.removeprefix("<library>/") if name.startswith("<library>/") else Path(name)


def pointed(diagnostics: Iterable[Diagnostic]) -> tuple[Diagnostic, ...]:
    """The diagnostics with the texts at the places that the IR keeps, where these can still be read."""
    texts = _Texts()
    return tuple(
        replace(d, place=texts.at(d.place), notes=tuple(replace(note, place=texts.at(note.place)) for note in d.notes))
        for d in diagnostics
    )


class _Texts:
    """The texts of files, each read once."""

    def __init__(self) -> None:
        self._sources: dict[str, Source | None] = {}

    def at(self, place: P) -> P | Span:
        """The text at a location; any other place as it is."""
        if not isinstance(place, Location) or (source := self._source(place.file)) is None:
            return place
        end = len(source.text)
        return Span(source, min(place.start, end), min(place.end, end))

    def _source(self, name: str) -> Source | None:
        if name not in self._sources:
            self._sources[name] = None  # of a task that was made in Python
            with suppress(WmsError):
                self._sources[name] = read_source(located(name))
        return self._sources[name]


def library_folder() -> Path:
    """The folder of the libraries that come with wmspec."""
    return resource("specs/library")


def catalogue_folders() -> tuple[Path, ...]:
    """The folders of the specs that rebuild the paper's tasks; those of the gallery are apart."""
    return resource("specs/perception"), resource("specs/prediction")


def search_path() -> tuple[Path, ...]:
    """The folders in WMSPEC_PATH, in which libraries are looked for too, parted as in PATH."""
    return tuple(Path(folder) for folder in os.environ.get("WMSPEC_PATH", "").split(os.pathsep) if folder)


def _uses(items: Iterable[Statement | Variant | Task]) -> Iterator[Use]:
    for item in items:
        if isinstance(item, Task | Variant):
            yield from _uses(item.body)
        elif isinstance(item, Use):
            yield item


def _collect(file: File, folder: Path, report: Report, program: Program, trail: tuple[tuple[Path, Span], ...]) -> None:
    for use in _uses(file.items):
        path = _find(use.name, folder, report)
        if path is None:
            continue
        if any(path == p for p, _ in trail):
            notes = tuple(Note("used from here", span) for _, span in trail)
            help = "move the shared part to a third library"
            report.add("WMS208", f"`{use.name.id}` uses itself in a circle", use.span, help, notes)
            continue
        program.paths[use.name.span] = path
        if path not in program.libraries:
            library, mistakes = _library(read_source(path))
            report.include(mistakes)
            _collect(library, path.parent, report, program, (*trail, (path, use.span)))
            program.libraries[path] = library


@lru_cache(maxsize=64)
def _library(source: Source) -> tuple[File, tuple[Diagnostic, ...]]:
    """A library as it is now, and its mistakes; parsed once for all specs that use it."""
    report = Report()
    return parse(source, report), report.diagnostics


def _find(name: Name, folder: Path, report: Report) -> Path | None:
    if not name.id:  # it is missing, and that was reported
        return None
    file = f"{name.id}.wms"
    if inside(folder, folder / file):
        return (folder / file).resolve()
    places = (*search_path(), library_folder())
    for place in places:  # which the user or wmspec chose: links may lead where they like
        with suppress(OSError):  # a name longer than file names can be
            if (path := place / file).is_file():
                return path.resolve()
    known = [p.stem for place in (folder, *places) for p in sorted(place.glob("*.wms"))]
    report.add(
        "WMS207",
        f"there is no library `{name.id}` next to the spec, on WMSPEC_PATH or in wmspec's own",
        name.span,
        suggestion(name.id, known),
    )
    return None
