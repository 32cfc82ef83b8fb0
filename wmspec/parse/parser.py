"""The parser: Lark's LALR tables over `grammar/wms.lark`, with recovery, so that one run finds every mistake."""

from __future__ import annotations

import re
from functools import cache
from typing import Any

from lark import Lark, Token, Tree
from lark.exceptions import UnexpectedToken
from lark.parsers.lalr_interactive_parser import InteractiveParser

from wmspec.parse.build import build_expression, build_file
from wmspec.parse.diagnostics import Report
from wmspec.parse.source import Source, Span
from wmspec.parse.syntax import Expr, File
from wmspec.parse.tables import lark_parser

#: Words that begin a statement or clause: after a mistake, reading goes on at the next of them.
STARTERS = frozenset(
    {"TASK", "USE", "FACTOR", "NUISANCE", "LET", "REQUIRE", "REPEAT", "OBJECT", "CAMERA", "LIGHT", "WORLD", "ACTION"}
    | {
        "HORIZON",
        "OBSERVE",
        "QUESTION",
        "SETTING",
        "OPTIONS",
        "ANSWER",
        "MARGIN",
        "ENSURE",
        "DISTINCT",
        "COUNTERFACTUAL",
    }
)
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
    return [token for token in _lark().lex(text, dont_ignore=True) if token.type != "WHITE"]


@cache
def _lark() -> Lark:
    return lark_parser()


def _run(source: Source, start: str, where: Span, report: Report) -> Tree[Token] | None:
    tokens = _tokens(source, where, report)
    parser = _lark().parse_interactive("", start=start)
    result, i = None, 0
    while i < len(tokens):
        try:
            result = parser.feed_token(tokens[i])
            i += 1
        except UnexpectedToken:
            _complain(source, tokens, i, _accepted(parser), report)
            i = _recover(parser, tokens, i) if start == "start" else len(tokens)
    return None if result is None or _too_deep(source, result, report) else result


def _tokens(source: Source, where: Span, report: Report) -> list[Token]:
    found = []
    for token in _lark().lex(where.text, dont_ignore=True):
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


def _complain(source: Source, tokens: list[Token], i: int, accepted: set[str], report: Report) -> None:
    token, span = tokens[i], _span(source, tokens[i])
    message = f"`{_shown(token)}` is unexpected here"
    expected = [SPOKEN[t] for t in sorted(accepted & SPOKEN.keys())]
    hint = f"expected {' or '.join(expected)}" if len(expected) in (1, 2, 3) else ""
    if token.type == "$END":
        span = _span(source, tokens[i - 1]) if i else span
        message = "the file ends too early"
    if "RBRACE" in accepted and (token.type == "$END" or token.type in STARTERS):
        hint = "is a `}` missing before this?"
    report.add("WMS101", message, span, hint)


def _accepted(parser: InteractiveParser) -> set[str]:
    accepted: set[str] = parser.accepts()  # type: ignore[no-untyped-call]
    return accepted


def _shown(token: Token) -> str:
    text = re.sub(r"\s+", " ", token)
    return text if len(text) <= 30 else text[:27] + "..."


def _recover(parser: InteractiveParser, tokens: list[Token], i: int) -> int:
    """Drop tokens up to the next start of a statement, property or `}`, and what was half read before it.

    Returns the index of the token to go on with; past the end if nothing fits.
    """
    stuck = i
    while i < len(tokens):
        if (i > stuck or tokens[i].type in STARTERS) and _boundary(tokens, i) and _unwind(parser, tokens[i].type):
            return i
        i += 1
    return i


def _boundary(tokens: list[Token], i: int) -> bool:
    return tokens[i].type in STARTERS or tokens[i].type in ("RBRACE", "$END") or tokens[i + 1].type == "COLON"


def _unwind(parser: InteractiveParser, token: str) -> bool:
    """Pop the parser's stack until it could go on with a token of this type; leave it alone if it never could."""
    state = parser.parser_state
    states, values = list(state.state_stack), list(state.value_stack)
    while token not in _accepted(parser):
        if not state.value_stack:
            state.state_stack[:], state.value_stack[:] = states, values
            return False
        state.state_stack.pop()
        state.value_stack.pop()
    return True


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
