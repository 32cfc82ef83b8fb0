"""Parser with error recovery: one run finds every syntax error."""

from __future__ import annotations

from wmspec.core.diagnostics import Report
from wmspec.core.places import Source, Span
from wmspec.lang.parse.braces import balance_braces, repair_indented_block
from wmspec.lang.parse.build import build_expression, build_file
from wmspec.lang.parse.confusables import replace_confusables
from wmspec.lang.parse.idioms import color_in_comment, hexadecimal_color, replace_idioms
from wmspec.lang.parse.lexer import Token, tokenize
from wmspec.lang.parse.lr_parser import END, LRParser, Tree
from wmspec.lang.parse.quotes import join_lines, repair_quotes
from wmspec.lang.parse.recover import drop_unreadable, recover
from wmspec.lang.parse.repair import apply_repair, keeps_names, repair
from wmspec.lang.parse.repair_candidates import INNER_KEYWORDS, SIGNS, short_text
from wmspec.lang.parse.syntax import Expr, File
from wmspec.lang.parse.tables import tables

#: Names of terminals in messages.
TERMINAL_NAMES = {"NAME": "a name", "STRING": "a text in quotes", "NUMBER": "a value"}
TERMINAL_NAMES |= {kind: f"`{sign}`" for kind, sign in SIGNS.items() if kind not in ("LPAR", "LSQB", "RANGE", "DOT")}
TERMINAL_NAMES |= {kind: f"`{word}`" for kind, word in INNER_KEYWORDS.items() if kind not in ("AT", "FOR")}
#: Deeper trees are rejected: recursive visitors would exhaust the stack.
MAX_DEPTH = 100
#: Maximum number of single repairs. Each one re-reads the text, so longer texts get fewer; later errors are dropped.
MAX_REPAIRS, MAX_REREAD_TOKENS = 24, 200_000
#: Maximum number of lines with quote repairs, and their maximum length (characters).
MAX_QUOTE_REPAIRS, MAX_QUOTE_LINE = 4, 300


def parse(source: Source, report: Report) -> File:
    """Parse a file. Syntax errors are reported; the tree holds all that could be parsed around them."""
    tree, whole = _run(source, "start", Span(source, 0, len(source.text)), report)
    return build_file(source, tree, report, whole) if tree else File((), Span(source, 0, 0), whole=False)


def parse_expression(span: Span, report: Report) -> Expr | None:
    """Parse the characters of a span as one expression (the `{...}` of a text)."""
    tree, _ = _run(span.source, "expr", span, report)
    return build_expression(span.source, tree, report) if tree else None


def tokens_and_comments(text: str) -> list[Token]:
    """Return the tokens of a text, comments included, in order."""
    return [token for token in tokenize(text) if token.type != "WHITE"]


def _run(source: Source, start: str, where: Span, report: Report) -> tuple[Tree | None, bool]:
    """Return the parse tree of the repaired text, and whether recovery dropped nothing."""
    tokens = _tokens(source, where, report)
    (machine, stuck), whole = _parse_prefix(start, tokens), True
    for _ in range(max(2, min(MAX_REPAIRS, MAX_REREAD_TOKENS // len(tokens)))):
        if stuck == len(tokens):
            break
        tokens, names_kept = _repair_error(source, start, machine, tokens, stuck, report)
        whole = whole and names_kept
        machine, stuck = _parse_prefix(start, tokens)
    while stuck < len(tokens):
        whole = False
        _report_unexpected(source, tokens, stuck, machine.accepted(), report)
        stuck = recover(machine, tokens, stuck) if start == "start" else len(tokens)
        while stuck < len(tokens) and machine.read(tokens[stuck]):
            stuck += 1
    tree = machine.result
    return (None if tree is None or _too_deep(source, tree, report) else tree), whole


def _parse_prefix(start: str, tokens: list[Token]) -> tuple[LRParser, int]:
    """Return the parser state after the longest readable prefix, and the index of the first token that it rejects."""
    machine = LRParser(start)
    for i, token in enumerate(tokens):
        if not machine.read(token):
            return machine, i
    return machine, len(tokens)


def _repair_error(
    source: Source, start: str, machine: LRParser, tokens: list[Token], stuck: int, report: Report
) -> tuple[list[Token], bool]:
    """Report and repair the error at token `stuck`; return the new tokens, and whether no name is missing."""
    inner = machine.accepts("RPAR") or machine.accepts("RSQB")
    braces = start == "start" and tokens[stuck].type in (END, "RBRACE") and not inner
    block = repair_indented_block(source, tokens, stuck) if start == "start" else None
    change = (balance_braces(source, tokens) if braces and block is None else None) or repair(
        start, tokens, stuck, block
    )
    if change is None:
        _report_unexpected(source, tokens, stuck, machine.accepted(), report)
        return (
            drop_unreadable(machine, tokens, stuck) if start == "start" else [Token("NAME", "", 0, 0), tokens[-1]]
        ), False
    if change.missing and change.start:
        before = _span(source, tokens[change.start - 1])
        span = Span(source, max(before.start, before.end - 1), before.end)
    else:
        last = tokens[max(change.start, change.stop - 1)]
        span = Span(source, tokens[change.start].start, max(last.end, tokens[change.start].start))
    stray = change.start < change.stop and tokens[change.start].type == "STRAY"
    report.add("WMS102" if stray else "WMS101", change.message, span, change.help)
    return apply_repair(change, tokens), keeps_names(change, tokens)


def _tokens(source: Source, where: Span, report: Report) -> list[Token]:
    tokens = _uncommented(source, where, report)
    for _ in range(MAX_QUOTE_REPAIRS):
        i = next((i for i, t in enumerate(tokens) if t.type == "OPEN_STRING"), None)
        if i is None:
            break
        tokens = _close_on_later_line(source, tokens, i, report) or _repair_quotes(source, where, tokens, i, report)
    while (i := next((i for i, t in enumerate(tokens) if t.type == "OPEN_STRING"), None)) is not None:
        tokens = _close_at_line_end(tokens, i, source, report)
    tokens = replace_idioms(source, list(replace_confusables(source, tokens, report)), report)
    return [*tokens, Token(END, "", where.end, source.position(where.end)[0])]


def _uncommented(source: Source, where: Span, report: Report) -> list[Token]:
    """Return the tokens without comments; a hexadecimal colour, which looks like one, is reported."""
    tokens = [t for t in tokenize(where.text, where.start) if t.type != "WHITE"]
    while (found := color_in_comment(tokens)) is not None:
        i, color = found
        comment, remedy = tokens[i], f"write `{hexadecimal_color(color[1:])}`"
        span = Span(source, comment.start, comment.start + len(color))
        report.add("WMS102", "`#` begins a comment, and no colour", span, remedy)
        rest = [t for t in tokenize(comment.text[len(color) :], span.end) if t.type != "WHITE"]
        made = comment._replace(type="NAME", text="gray")
        tokens = [*tokens[:i], made, *(t._replace(line=comment.line) for t in rest), *tokens[i + 1 :]]
    return [t for t in tokens if t.type != "COMMENT"]


def _repair_quotes(source: Source, where: Span, tokens: list[Token], i: int, report: Report) -> list[Token]:
    """Return the tokens with the quotes of a line with an unclosed text repaired."""
    number = source.position(tokens[i].start)[0]
    line = source.line(number)
    start = tokens[i].start - source.position(tokens[i].start)[1] + 1
    if len(line) > MAX_QUOTE_LINE or start < where.start or start + len(line) > where.end:
        return _close_at_line_end(tokens, i, source, report)
    before = [t for t in tokens if t.end <= start]
    after = [t for t in tokens if t.start >= start + len(line)]
    quote = repair_quotes(before, line, start, number, after)
    if quote is None:
        return _close_at_line_end(tokens, i, source, report)
    at = min(quote.offset, start + max(0, len(line) - 1))
    if quote.missing:
        report.add("WMS102", 'a `"` is missing here', Span(source, at, at + 1), "a text stands between two on one line")
    else:
        report.add("WMS102", 'this `"` is one too many', Span(source, at, at + 1), "remove it")
    return [*before, *quote.words, *after]


def _close_on_later_line(source: Source, tokens: list[Token], i: int, report: Report) -> list[Token] | None:
    """Return the tokens with a text that is closed on a following line; None if that is unlikely."""
    words = join_lines(source.text, tokens, i)
    if words is not None:
        remedy = 'close it on its line; a question may go on in the next: `"..." "..."`'
        report.add("WMS102", "a text ends on the line where it begins", _span(source, tokens[i]), remedy)
    return words


def _close_at_line_end(tokens: list[Token], i: int, source: Source, report: Report) -> list[Token]:
    """Return the tokens with a text from the quote to the end of its line, except closing brackets there."""
    token = tokens[i]
    report.add("WMS102", "this text has no closing quote on its line", _span(source, token), 'close it with `"`')
    text = token.text.rstrip(" \t{)],")
    rest = [t for t in tokenize(token.text[len(text) :], token.start + len(text)) if t.type != "WHITE"]
    rest = [t._replace(line=token.line) for t in rest]
    return [*tokens[:i], token._replace(type="STRING", text=f'{text}"'), *rest, *tokens[i + 1 :]]


def _span(source: Source, token: Token) -> Span:
    return Span(source, token.start, token.end)


def _report_unexpected(source: Source, tokens: list[Token], i: int, accepted: set[str], report: Report) -> None:
    token, span = tokens[i], _span(source, tokens[i])
    message = f"`{short_text(token)}` is unexpected here"
    if i and tokens[i - 1].type == "STRING":
        accepted = accepted - {"STRING"}  # a missing second piece of a text is never the error
    expected = [TERMINAL_NAMES[t] for t in sorted(accepted & TERMINAL_NAMES.keys())]
    hint = f"expected {' or '.join(expected)}" if len(expected) in (1, 2, 3) else ""
    if token.type == END:
        span = _span(source, tokens[i - 1]) if i else span
        message = "the file ends too early"
    if "RBRACE" in accepted and (token.type == END or token.type in tables().starters):
        hint = "is a `}` missing before this?"
    report.add("WMS101", message, span, hint)


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
