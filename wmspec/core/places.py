"""Places that diagnostics point to: in a source text, in a file, on a stage."""

from __future__ import annotations

import re
from bisect import bisect_right
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import PurePath
from typing import TypeAlias

from wmspec.core.node import Node


@dataclass(frozen=True)
class Source:
    """A source text and its display name: a path, or `<text>`."""

    name: str
    text: str = field(repr=False)

    @cached_property
    def _starts(self) -> list[int]:
        return [0, *(i + 1 for i, c in enumerate(self.text) if c == "\n")]

    def position(self, offset: int) -> tuple[int, int]:
        """Return line and column of a character, both from 1."""
        line = bisect_right(self._starts, offset)
        return line, offset - self._starts[line - 1] + 1

    def line(self, number: int) -> str:
        """Return the text of a line (from 1) without its line break."""
        start = self._starts[number - 1]
        end = self._starts[number] if number < len(self._starts) else len(self.text)
        return self.text[start:end].rstrip("\r\n")


#: A string literal (the group) or a comment.
_COMMENT = re.compile(r'("(?:[^"\\]|\\.)*")|#[^\n]*')


@dataclass(frozen=True)
class Span:
    """The characters `start`..`end` of a source."""

    source: Source
    start: int
    end: int

    @property
    def line(self) -> int:
        """The line on which the span begins, from 1."""
        return self.source.position(self.start)[0]

    @property
    def column(self) -> int:
        """The column at which the span begins, from 1."""
        return self.source.position(self.start)[1]

    @property
    def text(self) -> str:
        """The source text itself."""
        return self.source.text[self.start : self.end]

    @property
    def words(self) -> str:
        """The source text on one line, without comments."""
        return " ".join(_COMMENT.sub(r"\1", self.text).split())

    def to(self, other: Span) -> Span:
        """Return the span from the start of this one to the end of the other."""
        return Span(self.source, self.start, max(self.end, other.end))

    def __str__(self) -> str:
        return f"{self.source.name}:{self.line}:{self.column}"


class Location(Node, kw_only=True):
    """A place in a source text as plain values: file, line and column from 1, character offsets."""

    file: str
    line: int
    column: int
    start: int
    end: int

    @classmethod
    def of(cls, span: Span) -> Location:
        """Return the location of a span."""
        return cls(file=span.source.name, line=span.line, column=span.column, start=span.start, end=span.end)

    def __str__(self) -> str:
        return f"{self.file}:{self.line}:{self.column}"


@dataclass(frozen=True)
class PrimPlace:
    """A prim path; for a scene without a stage, the name of the body or action."""

    path: str

    def __str__(self) -> str:
        return self.path


@dataclass(frozen=True)
class FilePlace:
    """A file, optionally with a line (from 1) and an element such as `joint hinge`."""

    path: str
    line: int | None = None
    element: str = ""

    def __str__(self) -> str:
        line = "" if self.line is None else f":{self.line}"
        return f"{self.path}{line}" + (f": {self.element}" if self.element else "")


Place: TypeAlias = Span | Location | PrimPlace | FilePlace


def without_folder(place: Place) -> str:
    """Return a place with the name of its file alone: the text does not depend on where the file lies."""
    match place:
        case Span(source=Source(name=file)) | Location(file=file) | FilePlace(path=file):
            return PurePath(file).name + str(place).removeprefix(file)
    return str(place)
