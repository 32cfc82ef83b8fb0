"""Repair of missing and surplus quotes: tries one more or one fewer quote at every place of the line.

Alternatively a text continues over the end of its line.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from wmspec.lang.parse.lexer import Token, tokenize
from wmspec.lang.parse.lr_parser import LRParser

#: Number of tokens after the line that must be readable.
MAX_TOKENS_AHEAD = 8
#: Maximum number of lines of a text.
MAX_LINES = 4


@dataclass(frozen=True)
class QuoteRepair:
    """The repaired tokens of a line, and whether a quote is missing at the offset, or surplus there."""

    words: list[Token]
    offset: int
    missing: bool


def repair_quotes(before: list[Token], line: str, start: int, number: int, after: list[Token]) -> QuoteRepair | None:
    """Return the repair of a line (text, start offset, number) that lets the parser read furthest, or None.

    Among equals, texts without leading or trailing spaces win, then the longest quoted text.
    """
    first = LRParser("start")
    for token in before:
        first.shift(token.type)
    best, merit = None, (0, False, 0)
    for quote in _quote_repairs(line, start, number):
        if any(t.type == "OPEN_STRING" for t in quote.words):
            continue
        machine = LRParser("start")
        machine.states = list(first.states)
        if not all(machine.shift(t.type) for t in quote.words if t.type != "STRAY"):
            continue
        read_after = 0
        while read_after < min(MAX_TOKENS_AHEAD, len(after)) and machine.shift(after[read_after].type):
            read_after += 1
        texts = [t.text.strip('"') for t in quote.words if t.type in ("STRING", "LONG_STRING")]
        value = read_after + 1, all(text == text.strip() for text in texts), sum(map(len, texts))
        if value > merit:
            best, merit = quote, value
    return best


def join_lines(text: str, tokens: list[Token], i: int) -> list[Token] | None:
    """Return the tokens with one text from the quote of token `i` to the next unmatched quote.

    None if the tokens after it could not be read.
    """
    j = next((j for j in range(i + 1, len(tokens)) if tokens[j].type == "OPEN_STRING"), None)
    if j is None or tokens[j].line - tokens[i].line > MAX_LINES:
        return None
    first, last = tokens[i], tokens[j]
    quoted = first._replace(type="STRING", text=text[first.start : last.start + 1])
    rest = _words(last.text[1:], last.start + 1, last.line)
    words = [*tokens[:i], quoted, *rest, *tokens[j + 1 :]]
    machine = LRParser("start")
    return words if all(machine.shift(t.type) for t in words[: i + 1 + len(rest) + MAX_TOKENS_AHEAD]) else None


def _quote_repairs(line: str, start: int, number: int) -> Iterator[QuoteRepair]:
    edges = [i for i in range(len(line) + 1) if _is_text_edge(line, i)]
    for i in edges:
        words = [_original_position(t, start + i, 1) for t in _words(line[:i] + '"' + line[i:], start, number)]
        yield QuoteRepair(words, start + i, missing=True)
    for i in (i for i, c in enumerate(line) if c == '"'):
        words = [_original_position(t, start + i, -1) for t in _words(line[:i] + line[i + 1 :], start, number)]
        yield QuoteRepair(words, start + i, missing=False)


def _is_text_edge(line: str, i: int) -> bool:
    """Whether a text could begin or end here: not inside a word, nor between spaces."""
    left, right = line[i - 1 : i] if i else " ", line[i : i + 1] or " "
    return (left.isspace() != right.isspace()) or not (left.isalnum() or left.isspace()) or not right.isalnum()


def _words(line: str, start: int, number: int) -> list[Token]:
    return [t._replace(line=number) for t in tokenize(line, start) if t.type not in ("WHITE", "COMMENT")]


def _original_position(token: Token, at: int, by: int) -> Token:
    """Return the token with its position in the original text."""
    moved = token.start >= at if by > 0 else token.start > at
    return token._replace(start=max(0, token.start - by)) if moved else token
