"""The parser: Lark's LALR tables over `grammar/wms.lark`, with recovery, so that one run finds every mistake."""

from __future__ import annotations

import re
from collections.abc import Iterator
from copy import copy
from functools import cache
from typing import Any

from lark import Lark, Token, Tree
from lark.exceptions import UnexpectedToken
from lark.lexer import BasicLexer, LexerThread

from wmspec.parse.build import build_expression, build_file
from wmspec.parse.diagnostics import Report
from wmspec.parse.recover import STARTERS, accepted, recover
from wmspec.parse.source import Source, Span
from wmspec.parse.syntax import Expr, File
from wmspec.parse.tables import lark_parser

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
    """The tokens of a text with the comments among them, in order, each with its place (`start_pos`, `end_pos`)."""
    return [token for token in _read(text) if token.type != "WHITE"]


@cache
def _lark() -> Lark:
    return lark_parser()


@cache
def _lexer() -> BasicLexer:
    """Reads what the grammar ignores as well. Lark's own `lex` would make it anew for every text."""
    conf = copy(_lark().lexer_conf)
    conf.ignore = ()
    return BasicLexer(conf)


def _read(text: str) -> Iterator[Token]:
    thread: Any = LexerThread.from_text(_lexer(), text)
    yield from thread.lex(None)


def _run(source: Source, start: str, where: Span, report: Report) -> Tree[Token] | None:
    tokens = _tokens(source, where, report)
    parser = _lark().parse_interactive("", start=start)
    result, i = None, 0
    while i < len(tokens):
        try:
            result = parser.feed_token(tokens[i])
            i += 1
        except UnexpectedToken:
            _complain(source, tokens, i, accepted(parser), report)
            i = recover(parser, tokens, i) if start == "start" else len(tokens)
    return None if result is None or _too_deep(source, result, report) else result


def _tokens(source: Source, where: Span, report: Report) -> list[Token]:
    found = []
    for token in _read(where.text):
        token.start_pos = where.start + (token.start_pos or 0)
        token.end_pos = token.start_pos + len(token)
        if token.type == "STRAY":
            message = f"the character {str(token)!r} means nothing here"
            report.add("WMS102", message, _span(source, token), "remove it")
        elif token.type == "OPEN_STRING":
            message = "this text has no closing quote on its line"
            report.add("WMS102", message, _span(source, token), 'close it with `"`')
            found.append(Token.new_borrow_pos("STRING", f'{token}"', token))
        elif token.type not in ("WHITE", "COMMENT"):
            found.append(token)
    return [*found, Token("$END", "", start_pos=where.end, end_pos=where.end)]


def _span(source: Source, token: Token) -> Span:
    return Span(source, token.start_pos or 0, token.end_pos or 0)


def _complain(source: Source, tokens: list[Token], i: int, wanted: set[str], report: Report) -> None:
    token, span = tokens[i], _span(source, tokens[i])
    message = f"`{_shown(token)}` is unexpected here"
    expected = [SPOKEN[t] for t in sorted(wanted & SPOKEN.keys())]
    hint = f"expected {' or '.join(expected)}" if len(expected) in (1, 2, 3) else ""
    if token.type == "$END":
        span = _span(source, tokens[i - 1]) if i else span
        message = "the file ends too early"
    if "RBRACE" in wanted and (token.type == "$END" or token.type in STARTERS):
        hint = "is a `}` missing before this?"
    report.add("WMS101", message, span, hint)


def _shown(token: Token) -> str:
    text = re.sub(r"\s+", " ", token)
    return text if len(text) <= 30 else text[:27] + "..."


def _too_deep(source: Source, tree: Any, report: Report) -> bool:
    stack = [(tree, 0)]
    while stack:
        node, depth = stack.pop()
        if not isinstance(node, Tree):
            continue
        if depth > MAX_DEPTH:
            span = Span(source, node.meta.start_pos, node.meta.end_pos)
            report.add("WMS105", "this is nested too deeply", span, "give its parts names with `let`")
            return True
        stack += [(child, depth + 1) for child in node.children]
    return False
