"""The parser: the machine fed with the words of a text, with recovery, so that one run finds every mistake."""

from __future__ import annotations

import re

from wmspec.diagnostics import Report
from wmspec.parse.build import build_expression, build_file
from wmspec.parse.machine import END, Machine, Tree
from wmspec.parse.recover import recover
from wmspec.parse.syntax import Expr, File
from wmspec.parse.tables import tables
from wmspec.parse.words import Token, read
from wmspec.places import Source, Span

#: How a terminal is called in a message.
SPOKEN = {
    "NAME": "a name",
    "STRING": "a text in quotes",
    "LBRACE": "`{`",
    "RBRACE": "`}`",
    "COLON": "`:`",
    "EQUAL": "`=`",
    "RPAR": "`)`",
    "RSQB": "`]`",
    "COMMA": "`,`",
    "IN": "`in`",
    "BY": "`by`",
    "APART": "`apart by`",
    "THEN": "`then`",
    "ELSE": "`else`",
    "NUMBER": "a value",
}
#: Deeper trees are refused: whoever walks one recursively would exhaust the stack.
MAX_DEPTH = 100


def parse(source: Source, report: Report) -> File:
    """Parse a file. Mistakes go to the report; the tree holds whatever could be read around them."""
    tree = _run(source, "start", Span(source, 0, len(source.text)), report)
    return build_file(source, tree, report) if tree else File((), Span(source, 0, 0))


def parse_expression(span: Span, report: Report) -> Expr | None:
    """Parse the characters of a span as one expression (the `{...}` of a text)."""
    tree = _run(span.source, "expr", span, report)
    return build_expression(span.source, tree, report) if tree else None


def words(text: str) -> list[Token]:
    """The words of a text with the comments among them, in order."""
    return [token for token in read(text) if token.type != "WHITE"]


def _run(source: Source, start: str, where: Span, report: Report) -> Tree | None:
    tokens = _tokens(source, where, report)
    machine = Machine(start)
    i = 0
    while i < len(tokens):
        if machine.read(tokens[i]):
            i += 1
        else:
            _complain(source, tokens, i, machine.accepted(), report)
            i = recover(machine, tokens, i) if start == "start" else len(tokens)
    return None if machine.result is None or _too_deep(source, machine.result, report) else machine.result


def _tokens(source: Source, where: Span, report: Report) -> list[Token]:
    found = []
    for token in read(where.text, where.start):
        if token.type == "STRAY":
            message = f"the character {token.text!r} means nothing here"
            report.add("WMS102", message, _span(source, token), "remove it")
        elif token.type == "OPEN_STRING":
            message = "this text has no closing quote on its line"
            report.add("WMS102", message, _span(source, token), 'close it with `"`')
            found.append(token._replace(type="STRING", text=f'{token.text}"'))
        elif token.type not in ("WHITE", "COMMENT"):
            found.append(token)
    return [*found, Token(END, "", where.end, 0)]


def _span(source: Source, token: Token) -> Span:
    return Span(source, token.start, token.end)


def _complain(source: Source, tokens: list[Token], i: int, wanted: set[str], report: Report) -> None:
    token, span = tokens[i], _span(source, tokens[i])
    message = f"`{_shown(token)}` is unexpected here"
    expected = [SPOKEN[t] for t in sorted(wanted & SPOKEN.keys())]
    hint = f"expected {' or '.join(expected)}" if len(expected) in (1, 2, 3) else ""
    if token.type == END:
        span = _span(source, tokens[i - 1]) if i else span
        message = "the file ends too early"
    if "RBRACE" in wanted and (token.type == END or token.type in tables().starters):
        hint = "is a `}` missing before this?"
    report.add("WMS101", message, span, hint)


def _shown(token: Token) -> str:
    text = re.sub(r"\s+", " ", token.text)
    return text if len(text) <= 30 else text[:27] + "..."


def _too_deep(source: Source, tree: Tree, report: Report) -> bool:
    stack = [(tree, 0)]
    while stack:
        node, depth = stack.pop()
        if depth > MAX_DEPTH:
            span = Span(source, node.start, node.end)
            report.add("WMS105", "this is nested too deeply", span, "give its parts names with `let`")
            return True
        stack += [(child, depth + 1) for child in node.children if isinstance(child, Tree)]
    return False
