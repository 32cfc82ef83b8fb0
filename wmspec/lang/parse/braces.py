"""Braces that do not pair up: which one is missing or too many, as the beginnings of the lines tell."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from wmspec.core.places import Source
from wmspec.lang.parse.lexer import Token
from wmspec.lang.parse.repair_candidates import Repair


def rebraced(source: Source, tokens: Sequence[Token]) -> Repair | None:
    """The change after which there are as many braces closed as opened; None if there are already."""
    balance = sum((t.type == "LBRACE") - (t.type == "RBRACE") for t in tokens)
    if balance < 0:
        i = next(_surplus(source, tokens), None)
        last = max((i for i, t in enumerate(tokens) if t.type == "RBRACE"), default=0)
        at = last if i is None else i
        return Repair(at, at + 1, (), "this `}` is one too many", "remove it", 0)
    if balance > 0:
        at = _missing(source, tokens)
        made = Token("RBRACE", "", tokens[at].start, tokens[at].line)
        return Repair(at, at, (made,), "`}` is missing here", "write `}`", 0, missing=True)
    return None


def indented(source: Source, tokens: Sequence[Token], stuck: int) -> Repair | None:
    """A block without braces, as in Python, with or without a colon: it has as many lines as are further in."""
    colons = (i for i in range(stuck, max(0, stuck - 3), -1) if tokens[i].type == "COLON" and _begins(tokens, i + 1))
    i = next(colons, stuck)
    colon = tokens[i].type == "COLON"
    deep = _indent(source, tokens[i if colon else i - 1].line)
    if not colon and not (i and _begins(tokens, i) and _indent(source, tokens[i].line) > deep):
        return None
    inner = range(i + 1, len(tokens))
    end = next((j for j in inner if _begins(tokens, j) and _indent(source, tokens[j].line) <= deep), len(tokens) - 1)
    closed = tokens[end].type == "RBRACE" and _indent(source, tokens[end].line) == deep
    what = "`:` opens no block" if colon else "`{` is missing here"
    help = "write `{`" if closed else "write `{`, and `}` where it ends"
    opened = (tokens[i]._replace(type="LBRACE", text="{"),)
    return Repair(i, i + colon, opened, what, help, 0.5, missing=not colon, closes=None if closed else end)


def _begins(tokens: Sequence[Token], i: int) -> bool:
    """Whether a word is the first of its line."""
    return i < len(tokens) and tokens[i - 1].end_line < tokens[i].line


def _surplus(source: Source, tokens: Sequence[Token]) -> Iterator[int]:
    """Closing braces that stand in a line after something else, and close what does not begin in this line."""
    opened: list[int] = []
    for i, token in enumerate(tokens):
        if token.type == "LBRACE":
            opened.append(token.line)
        elif token.type == "RBRACE":
            line = opened.pop() if opened else 0
            alone = i == 0 or tokens[i - 1].end_line < token.line
            if line != token.line and (not alone or (line and _indent(source, line) != _indent(source, token.line))):
                yield i


def _missing(source: Source, tokens: Sequence[Token]) -> int:
    """The word before which the brace is missing: the first that begins a line no further in than what it closes.

    What is not closed is the first brace whose partner begins a line less far in than its own does, or has none.
    """
    opened: list[int] = []
    unclosed: list[int] = []
    for i, token in enumerate(tokens):
        if token.type == "LBRACE":
            opened.append(i)
        elif token.type == "RBRACE" and opened:
            at = opened.pop()
            if tokens[at].line != token.line and _indent(source, tokens[at].line) > _indent(source, token.line):
                unclosed.append(at)
    at = min(unclosed or opened)
    deep = _indent(source, tokens[at].line)
    for i in range(at + 1, len(tokens)):
        first = tokens[i - 1].end_line < tokens[i].line
        if first and tokens[i].line > tokens[at].line and _indent(source, tokens[i].line) <= deep:
            return i
    return len(tokens) - 1


def _indent(source: Source, line: int) -> int:
    text = source.line(line)
    return len(text) - len(text.lstrip())
