"""Diagnostics: message, place and remedy, and the errors that carry them.

Every layer raises a `WmsError` for the first error or collects all of them in a `Report`. Callers read fields such as
`code` and `place`; no text is parsed back.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, replace
from typing import Any, ClassVar, Literal, Self

from wmspec.core.places import FilePlace, Location, Place, PrimPlace, Span, without_folder
from wmspec.core.spelling import closest_word

Severity = Literal["error", "warning"]
Part = Literal["error", "warning", "note", "help", "caret"]

#: Colours a part of a rendered diagnostic.
Paint = Callable[[str, Part], str]


def unpainted(text: str, _part: Part) -> str:
    """Return the text without colour."""
    return text


_NAME = re.compile(r"(?<![\w./])[A-Za-z_]\w*")
#: Control characters and marks of text direction.
_CONTROLS = re.compile("[\x00-\x08\x0b-\x1f\x7f-\x9f\u200e\u200f\u202a-\u202e\u2066-\u2069]")


def escape_controls(text: str) -> str:
    """Return an untrusted text that is safe to print: each control character becomes one visible sign."""
    return _CONTROLS.sub(lambda match: chr(0x2400 + ord(match[0])) if match[0] < " " else "\ufffd", text)


@dataclass(frozen=True)
class Note:
    """A secondary place of a diagnostic."""

    message: str
    place: Place


@dataclass(frozen=True)
class Diagnostic:
    """One error or warning: message, place, remedy (`help`), secondary places, and a code of the language if any.

    `str` gives one line: `place: message; place of a note: note; help`.
    """

    message: str
    place: Place | None = None
    help: str = ""
    code: str = ""
    notes: tuple[Note, ...] = ()
    severity: Severity = "error"

    def __str__(self) -> str:
        return self._line(str)

    @property
    def portable(self) -> str:
        """As `str`, with the names of files without their folders."""
        return self._line(without_folder)

    def _line(self, named: Callable[[Place], str]) -> str:
        notes = (f"{named(note.place)}: {note.message}" for note in self.notes)
        text = "; ".join((self.message, *notes, *((self.help,) if self.help else ())))
        return text if self.place is None else f"{named(self.place)}: {text}"

    def at(self, place: Place) -> Diagnostic:
        """Return the diagnostic with this place unless it has one."""
        return self if self.place else replace(self, place=place)

    def named_at(self, place: Place) -> Diagnostic:
        """Return the diagnostic at the reference to a file; the place within the file moves into the message."""
        return replace(
            self, message=self.message if self.place is None else f"{self.place}: {self.message}", place=place
        )

    def render(self, paint: Paint = unpainted) -> str:
        """Render headline, source line with caret, notes and remedy; one line if there is no source text."""
        label = paint(f"{self.severity}[{self.code}]" if self.code else self.severity, self.severity)
        if not isinstance(self.place, Span):
            return f"{label}: {escape_controls(str(self))}"
        lines = [f"{label}: {escape_controls(self.message)}", *_excerpt(self.place, paint)]
        for note in self.notes:
            lines += [f"{paint('note', 'note')}: {escape_controls(note.message)}", *_excerpt(note.place, paint)]
        return "\n".join([*lines, f"{paint('help', 'help')}: {escape_controls(self.help)}"] if self.help else lines)

    def record(self) -> dict[str, object]:
        """Return the diagnostic as plain values for JSON."""
        return {
            "code": self.code,
            "severity": self.severity,
            "message": self.message,
            **place_record(self.place),
            "help": self.help,
            "notes": [{"message": n.message, **place_record(n.place)} for n in self.notes],
        }


def place_record(place: Place | None) -> dict[str, Any]:
    """Return a place as plain values: file, line and column, or the path of a prim."""
    match place:
        case Span(source=source, end=end):
            line, column = source.position(end)
            here = {"file": source.name, "line": place.line, "column": place.column}
            return {**here, "endLine": line, "endColumn": column}
        case Location():
            return {"file": place.file, "line": place.line, "column": place.column}
        case FilePlace(path, line):
            return {"file": path} if line is None else {"file": path, "line": line}
        case PrimPlace(path):
            return {"prim": path}
        case None:
            return {}


def _excerpt(place: Place, paint: Paint) -> Iterator[str]:
    if not isinstance(place, Span):
        yield f" --> {escape_controls(str(place))}"
        return
    text = place.source.line(place.line)
    start = place.column - 1
    window = max(0, start - 100)
    shown = escape_controls(text[window : window + 160].replace("\t", " "))
    carets = max(1, min(place.end - place.start, len(text) - start, 160))
    gutter = " " * len(str(place.line))
    yield f"{gutter}--> {escape_controls(str(place))}"
    yield f"{gutter} |"
    yield f"{place.line} | {shown}"
    yield paint(f"{gutter} | {' ' * (start - window)}{'^' * carets}", "caret")


# ---------------------------------------------------------------- raised


class WmsError(Exception):
    """Invalid input, or a capability that the machine lacks: one diagnostic, or several (`WmsError.of`).

    The command line prints it and exits with code 2. Pickling preserves it.
    """

    code: ClassVar[str] = ""
    """The default code of its diagnostics."""

    diagnostics: tuple[Diagnostic, ...]

    def __init__(
        self, message: str, place: Place | None = None, help: str = "", *, code: str = "", notes: tuple[Note, ...] = ()
    ) -> None:
        super().__init__(message)
        self.diagnostics = (Diagnostic(message, place, help, code or self.code, notes),)

    @classmethod
    def of(cls, diagnostics: Iterable[Diagnostic]) -> Self:
        """Return an error with one or more diagnostics."""
        error = cls("")
        error.diagnostics = tuple(diagnostics)
        return error

    def at(self, place: Place) -> Self:
        """Return the error with this place for diagnostics that have none."""
        return self.of(d.at(place) for d in self.diagnostics)

    def __str__(self) -> str:
        return "\n".join(map(str, self.diagnostics))

    @property
    def portable(self) -> str:
        """The text of `str(error)`, with folders cut from file names, to store in a dataset."""
        return "\n".join(diagnostic.portable for diagnostic in self.diagnostics)

    def render(self, paint: Paint = unpainted) -> str:
        """Render all diagnostics."""
        return "\n\n".join(diagnostic.render(paint) for diagnostic in self.diagnostics)

    def __reduce__(self) -> tuple[object, ...]:
        return type(self).of, (self.diagnostics,)


class SpecError(WmsError):
    """A spec has errors; `diagnostics` holds all of them."""


class ImpossibleValue(SpecError):
    """The values of an instance are contradictory."""

    code = "WMS304"


class StageError(WmsError):
    """A stage, or the scene read from it, cannot be executed: all reasons."""


class EngineError(WmsError):
    """An engine failed on this episode: a diverged state, or a warning that the engine hides."""


class GraphicsError(WmsError):
    """An engine cannot draw on this machine, independent of the episode."""


# ---------------------------------------------------------------- collected


class Report:
    """Collects diagnostics without duplicates and orders them by place."""

    def __init__(self, error: type[WmsError] = SpecError) -> None:
        self.names: dict[str, str] = {}
        """Source spelling of generated names, such as `tiles[1]` for `tiles_1`."""
        self._error = error
        self._diagnostics: dict[tuple[str, str, str], Diagnostic] = {}

    def add(
        self,
        code: str,
        message: str,
        place: Place | None,
        help: str = "",
        notes: tuple[Note, ...] = (),
        severity: Severity = "error",
    ) -> None:
        """Record a diagnostic."""
        self.include([Diagnostic(message, place, help, code, notes, severity)])

    def add_repeated(
        self,
        named: Iterable[tuple[str, Place]],
        message: str,
        help: str = "give one of them another name",
        note: str = "declared here first",
    ) -> None:
        """Record each name that is declared again; in the message, `{}` stands for it."""
        first: dict[str, Place] = {}
        for name, place in named:
            if name in first:
                self.add("WMS202", message.format(name), place, help, (Note(note, first[name]),))
            first.setdefault(name, place)

    def add_set_twice(self, named: Iterable[tuple[str, Place]], message: str = "`{}` is set twice") -> None:
        """Record each name that is set again; in the message, `{}` stands for it."""
        self.add_repeated(named, message, "remove one", "first set here")

    def include(self, diagnostics: Iterable[Diagnostic]) -> None:
        """Record the diagnostics of an error or another report."""
        for d in diagnostics:
            self._diagnostics.setdefault((d.code, str(d.place), d.message), d)

    def merge(self, other: Report) -> None:
        """Record the diagnostics and name spellings of another report."""
        self.include(other.diagnostics)
        self.names |= other.names

    @contextmanager
    def collect_errors(self) -> Iterator[None]:
        """Record a `WmsError` raised in the block and continue after it."""
        try:
            yield
        except WmsError as error:
            self.include(error.diagnostics)

    @property
    def diagnostics(self) -> tuple[Diagnostic, ...]:
        """All diagnostics by file and place; those without a source text in the order of recording."""
        ordered = sorted(self._diagnostics.values(), key=lambda d: (*_order(d.place), d.code))
        return tuple(_written(d, self.names) for d in ordered) if self.names else tuple(ordered)

    @property
    def failed(self) -> bool:
        """Whether any diagnostic is an error."""
        return any(d.severity == "error" for d in self._diagnostics.values())

    def stop_if_failed(self) -> None:
        """Raise the report's error type with all diagnostics if any is an error."""
        if self.failed:
            raise self._error.of(self.diagnostics)


def _written(d: Diagnostic, names: Mapping[str, str]) -> Diagnostic:
    """Return the diagnostic with names in their source spelling."""

    def spelled(text: str) -> str:
        return _NAME.sub(lambda name: names.get(name[0], name[0]), text)

    help = (
        Remedy.of(spelled(d.help), d.help.wrong, spelled(d.help.right))
        if isinstance(d.help, Remedy)
        else spelled(d.help)
    )
    notes = tuple(replace(note, message=spelled(note.message)) for note in d.notes)
    return replace(d, message=spelled(d.message), help=help, notes=notes)


def _order(place: Place | None) -> tuple[str, int]:
    match place:
        case Span():
            return place.source.name, place.start
        case Location():
            return place.file, place.start
        case _:
            return "", 0


class Remedy(str):
    """A remedy that tools can apply: replace `wrong` by `right` at the place of the diagnostic."""

    __slots__ = ("right", "wrong")
    wrong: str
    right: str

    @classmethod
    def of(cls, words: str, wrong: str, right: str) -> Remedy:
        """Return a remedy with this text."""
        remedy = cls(words)
        remedy.wrong, remedy.right = wrong, right
        return remedy


#: Longer lists of known names are omitted.
MAX_LISTED_NAMES = 16


def suggestion(word: str, *groups: Iterable[str]) -> str:
    """Return `did you mean X?` for the known word closest to `word`; ties go to the earlier group.

    If none is close, return the list of the first short group, or an empty text.
    """
    known = [sorted(set(group)) for group in groups]
    if close := closest_word(word, *known):
        return Remedy.of(f"did you mean `{close}`?", word, close)
    few = next((names for names in known if 0 < len(names) <= MAX_LISTED_NAMES), ())
    return f"known here: {', '.join(few)}" if few else ""
