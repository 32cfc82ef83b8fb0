"""The words of a text, each with its type and place."""

from __future__ import annotations

import re
from collections.abc import Iterator
from functools import cache
from typing import NamedTuple

from wmspec.lang.parse.tables import tables

#: Words that may have a line end within.
_LONG = frozenset({"WHITE", "LONG_STRING", "STRAY"})


class Token(NamedTuple):
    """A word: its type (a terminal of the grammar), the offset where it starts, and its line from 1."""

    type: str
    text: str
    start: int
    line: int

    @property
    def end(self) -> int:
        """The offset after it."""
        return self.start + len(self.text)

    @property
    def end_line(self) -> int:
        """The line on which it ends."""
        return self.line + self.text.count("\n")


def read(text: str, offset: int = 0) -> Iterator[Token]:
    """All words of a text, white space and comments too, as if the text stood at an offset."""
    match, keywords, position, line = _pattern().match, tables().keywords, 0, 1
    while token := match(text, position):
        kind, word = token.lastgroup, token.group()
        assert kind is not None
        yield Token(keywords.get(word, kind) if kind == "NAME" else kind, word, offset + position, line)
        if kind in _LONG:
            line += word.count("\n")
        position += len(word)


@cache
def _pattern() -> re.Pattern[str]:
    return re.compile(tables().pattern)
