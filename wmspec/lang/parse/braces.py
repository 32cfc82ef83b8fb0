"""Repair of unbalanced braces, guided by indentation."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from wmspec.core.places import Source
from wmspec.lang.parse.lexer import Token
from wmspec.lang.parse.repair_candidates import Repair


def balance_braces(source: Source, tokens: Sequence[Token]) -> Repair | None:
    """Return the repair that balances the braces, or None if they are balanced."""
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


def repair_indented_block(source: Source, tokens: Sequence[Token], stuck: int) -> Repair | None:
    """Return the repair of a Python-style block (indentation, with or without a colon); it spans the indented lines."""
    colons = (
        i for i in range(stuck, max(0, stuck - 3), -1) if tokens[i].type == "COLON" and _begins_line(tokens, i + 1)
    )
    i = next(colons, stuck)
    colon = tokens[i].type == "COLON"
    deep = _indent(source, tokens[i if colon else i - 1].line)
    if not colon and not (i and _begins_line(tokens, i) and _indent(source, tokens[i].line) > deep):
        return None
    inner = range(i + 1, len(tokens))
    end = next(
        (j for j in inner if _begins_line(tokens, j) and _indent(source, tokens[j].line) <= deep), len(tokens) - 1
    )
    closed = tokens[end].type == "RBRACE" and _indent(source, tokens[end].line) == deep
    message = "`:` opens no block" if colon else "`{` is missing here"
    help = "write `{`" if closed else "write `{`, and `}` where it ends"
    opened = (tokens[i]._replace(type="LBRACE", text="{"),)
    return Repair(i, i + colon, opened, message, help, 0.5, missing=not colon, closes=None if closed else end)


def _begins_line(tokens: Sequence[Token], i: int) -> bool:
    """Whether token `i` is the first of its line."""
    return i < len(tokens) and tokens[i - 1].end_line < tokens[i].line


def _surplus(source: Source, tokens: Sequence[Token]) -> Iterator[int]:
    """Yield the indices of closing braces that follow other tokens on their line and close no block of that line."""
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
    """Return the index of the token before which a closing brace is missing.

    The unclosed brace is the first one whose partner is less indented, or that has no partner. The closing brace
    belongs before the first line that is not indented further than the line of the unclosed brace.
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
