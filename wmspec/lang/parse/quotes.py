"""Quotes that are missing or too many: the line is read with one more, and with one less, at every place.

Or a text goes on over the end of its line.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from wmspec.lang.parse.lexer import Token, read
from wmspec.lang.parse.machine import Machine

#: How many words after the line must be read.
AHEAD = 8
#: The most lines that a text goes on for.
MOST_LINES = 4


@dataclass(frozen=True)
class Quote:
    """The words of the line as they are meant, and whether a quote is missing at an offset, or too many there."""

    words: list[Token]
    offset: int
    missing: bool


def requoted(before: list[Token], line: str, start: int, number: int, after: list[Token]) -> Quote | None:
    """A line (its text, the offset where it starts, its number) with as many quotes as lets most be read after it.

    Of equals, one in which texts neither begin nor end with a space, and that in which most of the line is text.
    None if nothing helps.
    """
    first = Machine("start")
    for token in before:
        first.follow(token.type)
    best, merit = None, (0, False, 0)
    for quote in _ways(line, start, number):
        if any(t.type == "OPEN_STRING" for t in quote.words):
            continue
        machine = Machine("start")
        machine.states = list(first.states)
        if not all(machine.follow(t.type) for t in quote.words if t.type != "STRAY"):
            continue
        read_after = 0
        while read_after < min(AHEAD, len(after)) and machine.follow(after[read_after].type):
            read_after += 1
        texts = [t.text.strip('"') for t in quote.words if t.type in ("STRING", "LONG_STRING")]
        value = read_after + 1, all(text == text.strip() for text in texts), sum(map(len, texts))
        if value > merit:
            best, merit = quote, value
    return best


def unbroken(text: str, tokens: list[Token], i: int) -> list[Token] | None:
    """The words of a text with one quoted text from the quote of word `i` to the next that no line closes.

    None if what follows could not be read.
    """
    j = next((j for j in range(i + 1, len(tokens)) if tokens[j].type == "OPEN_STRING"), None)
    if j is None or tokens[j].line - tokens[i].line > MOST_LINES:
        return None
    first, last = tokens[i], tokens[j]
    quoted = first._replace(type="STRING", text=text[first.start : last.start + 1])
    rest = _words(last.text[1:], last.start + 1, last.line)
    words = [*tokens[:i], quoted, *rest, *tokens[j + 1 :]]
    machine = Machine("start")
    return words if all(machine.follow(t.type) for t in words[: i + 1 + len(rest) + AHEAD]) else None


def _ways(line: str, start: int, number: int) -> Iterator[Quote]:
    edges = [i for i in range(len(line) + 1) if _edge(line, i)]
    for i in edges:
        words = [_back(t, start + i, 1) for t in _words(line[:i] + '"' + line[i:], start, number)]
        yield Quote(words, start + i, missing=True)
    for i in (i for i, c in enumerate(line) if c == '"'):
        words = [_back(t, start + i, -1) for t in _words(line[:i] + line[i + 1 :], start, number)]
        yield Quote(words, start + i, missing=False)


def _edge(line: str, i: int) -> bool:
    """Whether a text could begin or end here: not within a word, nor between spaces."""
    left, right = line[i - 1 : i] if i else " ", line[i : i + 1] or " "
    return (left.isspace() != right.isspace()) or not (left.isalnum() or left.isspace()) or not right.isalnum()


def _words(line: str, start: int, number: int) -> list[Token]:
    return [t._replace(line=number) for t in read(line, start) if t.type not in ("WHITE", "COMMENT")]


def _back(token: Token, at: int, by: int) -> Token:
    """A word as it stands in the text that was written."""
    moved = token.start >= at if by > 0 else token.start > at
    return token._replace(start=max(0, token.start - by)) if moved else token
