"""Lexer: text to tokens with type and position."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from functools import cache
from itertools import pairwise
from typing import NamedTuple

from wmspec.lang.parse.tables import tables

#: Token types that may contain a line end.
_MULTILINE = frozenset({"WHITE", "LONG_STRING", "STRAY"})


class Token(NamedTuple):
    """A token: its type (a terminal of the grammar), text, start offset, and line (from 1)."""

    type: str
    text: str
    start: int
    line: int

    @property
    def end(self) -> int:
        """Offset after the token."""
        return self.start + len(self.text)

    @property
    def end_line(self) -> int:
        """Line on which the token ends."""
        return self.line + self.text.count("\n")


def tokenize(text: str, offset: int = 0) -> Iterator[Token]:
    """Yield all tokens of a text, with white space and comments; offsets start at `offset`."""
    match, keywords, position, line = _pattern().match, tables().keywords, 0, 1
    while token := match(text, position):
        kind, word = token.lastgroup, token.group()
        assert kind is not None
        yield Token(keywords.get(word, kind) if kind == "NAME" else kind, word, offset + position, line)
        if kind in _MULTILINE:
            line += word.count("\n")
        position += len(word)


def text_of(tokens: Sequence[Token]) -> str:
    """Return the tokens as written, on one line."""
    gaps = [" " * (b.start > a.end) for a, b in pairwise(tokens)]
    return "".join(t.text + gap for t, gap in zip(tokens, [*gaps, ""], strict=False))


@cache
def _pattern() -> re.Pattern[str]:
    return re.compile(tables().pattern)
