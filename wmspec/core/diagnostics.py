"""What is wrong, where, and what would be right: the one value, and the errors that carry it.

Every layer raises a `WmsError` for the first mistake, or collects all of them in a `Report`. What a reader of an error
wants to know (its code, its place) is in the value; no text is ever read back.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, replace
from typing import ClassVar, Literal, Self

from wmspec.core.places import FilePlace, Location, Place, PrimPlace, Span
from wmspec.core.spelling import nearest

Severity = Literal["error", "warning"]
Part = Literal["error", "warning", "note", "help", "caret"]

#: Gives a part of a rendered diagnostic its colour.
Paint = Callable[[str, Part], str]


def plain(text: str, _part: Part) -> str:
    """The text as it is."""
    return text


_NAME = re.compile(r"(?<![\w./])[A-Za-z_]\w*")
#: What a terminal obeys instead of showing it, or what turns the order of what follows.
_OBEYED = re.compile("[\x00-\x08\x0b-\x1f\x7f-\x9f\u200e\u200f\u202a-\u202e\u2066-\u2069]")


def visible(text: str) -> str:
    """A text that others wrote as it can be shown on a terminal: a sign, as wide, for each character that it obeys."""
    return _OBEYED.sub(lambda match: chr(0x2400 + ord(match[0])) if match[0] < " " else "\ufffd", text)


@dataclass(frozen=True)
class Note:
    """Another place that has to do with the mistake."""

    message: str
    place: Place


@dataclass(frozen=True)
class Diagnostic:
    """One mistake: one sentence, the place, a remedy, other places involved, and a code of the language if it has one.

    As a text it is one line: `place: message; place of a note: note; help`.
    """

    message: str
    place: Place | None = None
    help: str = ""
    code: str = ""
    notes: tuple[Note, ...] = ()
    severity: Severity = "error"

    def __str__(self) -> str:
        notes = (f"{note.place}: {note.message}" for note in self.notes)
        told = "; ".join((self.message, *notes, *((self.help,) if self.help else ())))
        return told if self.place is None else f"{self.place}: {told}"

    def at(self, place: Place) -> Diagnostic:
        """The same for whoever knows where it is: with this place, unless it has one."""
        return self if self.place else replace(self, place=place)

    def named_at(self, place: Place) -> Diagnostic:
        """The same where the text stands that names the file: where it is in that is told in the sentence."""
        return replace(
            self, message=self.message if self.place is None else f"{self.place}: {self.message}", place=place
        )

    def render(self, paint: Paint = plain) -> str:
        """With its text, the diagnostic is a headline, the line with a caret, notes and the remedy; else one line."""
        label = paint(f"{self.severity}[{self.code}]" if self.code else self.severity, self.severity)
        if not isinstance(self.place, Span):
            return f"{label}: {visible(str(self))}"
        lines = [f"{label}: {visible(self.message)}", *_excerpt(self.place, paint)]
        for note in self.notes:
            lines += [f"{paint('note', 'note')}: {visible(note.message)}", *_excerpt(note.place, paint)]
        return "\n".join([*lines, f"{paint('help', 'help')}: {visible(self.help)}"] if self.help else lines)

    def record(self) -> dict[str, object]:
        """The diagnostic as plain values, for JSON."""
        return {
            "code": self.code,
            "severity": self.severity,
            "message": self.message,
            **_record(self.place),
            "help": self.help,
            "notes": [{"message": n.message, **_record(n.place)} for n in self.notes],
        }


def _record(place: Place | None) -> dict[str, object]:
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
        yield f" --> {visible(str(place))}"
        return
    text = place.source.line(place.line)
    start = place.column - 1
    window = max(0, start - 100)
    shown = visible(text[window : window + 160].replace("\t", " "))
    carets = max(1, min(place.end - place.start, len(text) - start, 160))
    gutter = " " * len(str(place.line))
    yield f"{gutter}--> {visible(str(place))}"
    yield f"{gutter} |"
    yield f"{place.line} | {shown}"
    yield paint(f"{gutter} | {' ' * (start - window)}{'^' * carets}", "caret")


# ---------------------------------------------------------------- raised


class WmsError(Exception):
    """A mistake in what the user gave us, or what a machine lacks: one diagnostic, or several with `of`.

    The command line prints it and exits with code 2. Pickled, as from a worker process, it stays whole.
    """

    code: ClassVar[str] = ""
    """Of a diagnostic that is given none."""

    diagnostics: tuple[Diagnostic, ...]

    def __init__(
        self, message: str, place: Place | None = None, help: str = "", *, code: str = "", notes: tuple[Note, ...] = ()
    ) -> None:
        super().__init__(message)
        self.diagnostics = (Diagnostic(message, place, help, code or self.code, notes),)

    @classmethod
    def of(cls, diagnostics: Iterable[Diagnostic]) -> Self:
        """The error that carries these diagnostics, of which there is at least one."""
        error = cls("")
        error.diagnostics = tuple(diagnostics)
        return error

    def at(self, place: Place) -> Self:
        """The same error for whoever knows where it happened: its diagnostics without a place have this one."""
        return self.of(d.at(place) for d in self.diagnostics)

    def __str__(self) -> str:
        return "\n".join(map(str, self.diagnostics))

    def render(self, paint: Paint = plain) -> str:
        """All that is wrong as a user reads it, one after the other."""
        return "\n\n".join(diagnostic.render(paint) for diagnostic in self.diagnostics)

    def __reduce__(self) -> tuple[object, ...]:
        return type(self).of, (self.diagnostics,)


class SpecError(WmsError):
    """A spec has mistakes: all of them."""


class ImpossibleValue(SpecError):
    """What the values of an instance make impossible."""

    code = "WMS304"


class StageError(WmsError):
    """A stage, or the scene read from it, cannot be executed: everything that is wrong with it."""


class EngineError(WmsError):
    """An engine gave up or returned nonsense for this episode (a diverged state, a warning that it hides)."""


class GraphicsError(WmsError):
    """This machine cannot draw with an engine: nothing that an episode could be blamed for."""


# ---------------------------------------------------------------- collected


class Report:
    """Collects diagnostics, each once, and gives them in the order of the text."""

    def __init__(self, error: type[WmsError] = SpecError) -> None:
        self.names: dict[str, str] = {}
        """What is written for names that wmspec made, `tiles[1]` for `tiles_1`: so they are told."""
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
        """Record a mistake."""
        self.include([Diagnostic(message, place, help, code, notes, severity)])

    def include(self, diagnostics: Iterable[Diagnostic]) -> None:
        """Record mistakes that another report, or an error, has."""
        for d in diagnostics:
            self._diagnostics.setdefault((d.code, str(d.place), d.message), d)

    def take(self, other: Report) -> None:
        """Record all that another report has, and how it tells names."""
        self.include(other.diagnostics)
        self.names |= other.names

    @contextmanager
    def gathered(self) -> Iterator[None]:
        """Record a `WmsError` of the block and go on after it."""
        try:
            yield
        except WmsError as error:
            self.include(error.diagnostics)

    @property
    def diagnostics(self) -> tuple[Diagnostic, ...]:
        """All that was recorded, by file and place; what is in no text in the order in which it was."""
        ordered = sorted(self._diagnostics.values(), key=lambda d: (*_order(d.place), d.code))
        return tuple(_written(d, self.names) for d in ordered) if self.names else tuple(ordered)

    @property
    def failed(self) -> bool:
        """Whether anything recorded is an error."""
        return any(d.severity == "error" for d in self._diagnostics.values())

    def stop_if_failed(self) -> None:
        """Raise the report's kind of error with everything recorded if anything is an error."""
        if self.failed:
            raise self._error.of(self.diagnostics)


def _written(d: Diagnostic, names: Mapping[str, str]) -> Diagnostic:
    """The diagnostic with names as they are written."""

    def told(text: str) -> str:
        return _NAME.sub(lambda name: names.get(name[0], name[0]), text)

    help = Remedy.of(told(d.help), d.help.wrong, told(d.help.right)) if isinstance(d.help, Remedy) else told(d.help)
    notes = tuple(replace(note, message=told(note.message)) for note in d.notes)
    return replace(d, message=told(d.message), help=help, notes=notes)


def _order(place: Place | None) -> tuple[str, int]:
    match place:
        case Span():
            return place.source.name, place.start
        case Location():
            return place.file, place.start
        case _:
            return "", 0


class Remedy(str):
    """A remedy in words that can also be applied: `right` in the place of `wrong`, where the diagnostic points."""

    __slots__ = ("right", "wrong")
    wrong: str
    right: str

    @classmethod
    def of(cls, words: str, wrong: str, right: str) -> Remedy:
        """The remedy that is told in these words."""
        remedy = cls(words)
        remedy.wrong, remedy.right = wrong, right
        return remedy


#: No more words than these are listed.
FEW = 16


def suggestion(word: str, *groups: Iterable[str]) -> str:
    """`did you mean X?` for the known word closest to `word`, of equals one of an earlier group.

    If none is close, a list of the first group that has a few, or nothing.
    """
    known = [sorted(set(group)) for group in groups]
    if close := nearest(word, *known):
        return Remedy.of(f"did you mean `{close}`?", word, close)
    few = next((names for names in known if 0 < len(names) <= FEW), ())
    return f"known here: {', '.join(few)}" if few else ""
