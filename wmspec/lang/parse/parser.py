"""The parser: the machine fed with the words of a text, with recovery, so that one run finds every mistake."""

from __future__ import annotations

from wmspec.core.diagnostics import Report
from wmspec.core.places import Source, Span
from wmspec.lang.parse.braces import indented, rebraced
from wmspec.lang.parse.build import build_expression, build_file
from wmspec.lang.parse.confusables import readable
from wmspec.lang.parse.lexer import Token, read
from wmspec.lang.parse.machine import END, Machine, Tree
from wmspec.lang.parse.quotes import requoted, unbroken
from wmspec.lang.parse.recover import dropped, recover
from wmspec.lang.parse.repair import repair, repaired, sure
from wmspec.lang.parse.repair_candidates import shown
from wmspec.lang.parse.syntax import Expr, File
from wmspec.lang.parse.tables import tables

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
#: So many mistakes are mended one by one, in longer texts fewer, for each time all is read anew; after that what cannot
#: be read is dropped.
MOST_REPAIRS, MOST_WORDS = 24, 200_000
#: So many lines with quotes missing are mended, if they are no longer than this.
MOST_QUOTES, MOST_LINE = 4, 300


def parse(source: Source, report: Report) -> File:
    """Parse a file. Mistakes go to the report; the tree holds whatever could be read around them."""
    tree, whole = _run(source, "start", Span(source, 0, len(source.text)), report)
    return build_file(source, tree, report, whole) if tree else File((), Span(source, 0, 0), whole=False)


def parse_expression(span: Span, report: Report) -> Expr | None:
    """Parse the characters of a span as one expression (the `{...}` of a text)."""
    tree, _ = _run(span.source, "expr", span, report)
    return build_expression(span.source, tree, report) if tree else None


def words(text: str) -> list[Token]:
    """The words of a text with the comments among them, in order."""
    return [token for token in read(text) if token.type != "WHITE"]


def _run(source: Source, start: str, where: Span, report: Report) -> tuple[Tree | None, bool]:
    """The tree of what is written, or of what was most likely meant; and whether nothing had to be left out."""
    tokens = _tokens(source, where, report)
    (machine, stuck), whole = _fed(start, tokens), True
    for _ in range(max(2, min(MOST_REPAIRS, MOST_WORDS // len(tokens)))):
        if stuck == len(tokens):
            break
        tokens, mended = _mended(source, start, machine, tokens, stuck, report)
        whole = whole and mended
        machine, stuck = _fed(start, tokens)
    while stuck < len(tokens):
        whole = False
        _complain(source, tokens, stuck, machine.accepted(), report)
        stuck = recover(machine, tokens, stuck) if start == "start" else len(tokens)
        while stuck < len(tokens) and machine.read(tokens[stuck]):
            stuck += 1
    tree = machine.result
    return (None if tree is None or _too_deep(source, tree, report) else tree), whole


def _fed(start: str, tokens: list[Token]) -> tuple[Machine, int]:
    """The machine with what it can read, and the index of the first word that it cannot."""
    machine = Machine(start)
    for i, token in enumerate(tokens):
        if not machine.read(token):
            return machine, i
    return machine, len(tokens)


def _mended(
    source: Source, start: str, machine: Machine, tokens: list[Token], stuck: int, report: Report
) -> tuple[list[Token], bool]:
    """The words without the mistake at which reading is stuck, which is reported; and whether no name is missing."""
    inner = machine.takes("RPAR") or machine.takes("RSQB")
    braces = start == "start" and tokens[stuck].type in (END, "RBRACE") and not inner
    block = indented(source, tokens, stuck) if start == "start" else None
    change = (rebraced(source, tokens) if braces and block is None else None) or repair(start, tokens, stuck, block)
    if change is None:
        _complain(source, tokens, stuck, machine.accepted(), report)
        return (dropped(machine, tokens, stuck) if start == "start" else [Token("NAME", "", 0, 0), tokens[-1]]), False
    if change.missing and change.start:
        before = _span(source, tokens[change.start - 1])
        span = Span(source, max(before.start, before.end - 1), before.end)
    else:
        last = tokens[max(change.start, change.stop - 1)]
        span = Span(source, tokens[change.start].start, max(last.end, tokens[change.start].start))
    stray = change.start < change.stop and tokens[change.start].type == "STRAY"
    report.add("WMS102" if stray else "WMS101", change.message, span, change.help)
    return repaired(change, tokens), sure(change, tokens)


def _tokens(source: Source, where: Span, report: Report) -> list[Token]:
    tokens = [t for t in read(where.text, where.start) if t.type not in ("WHITE", "COMMENT")]
    for _ in range(MOST_QUOTES):
        i = next((i for i, t in enumerate(tokens) if t.type == "OPEN_STRING"), None)
        if i is None:
            break
        tokens = _over_lines(source, tokens, i, report) or _closed(source, where, tokens, i, report)
    while (i := next((i for i, t in enumerate(tokens) if t.type == "OPEN_STRING"), None)) is not None:
        tokens = _as_text(tokens, i, source, report)
    return [*readable(source, tokens, report), Token(END, "", where.end, source.position(where.end)[0])]


def _closed(source: Source, where: Span, tokens: list[Token], i: int, report: Report) -> list[Token]:
    """The words with as many quotes on the line of a text that is not closed as are meant."""
    number = source.position(tokens[i].start)[0]
    line = source.line(number)
    start = tokens[i].start - source.position(tokens[i].start)[1] + 1
    if len(line) > MOST_LINE or start < where.start or start + len(line) > where.end:
        return _as_text(tokens, i, source, report)
    before = [t for t in tokens if t.end <= start]
    after = [t for t in tokens if t.start >= start + len(line)]
    quote = requoted(before, line, start, number, after)
    if quote is None:
        return _as_text(tokens, i, source, report)
    at = min(quote.offset, start + max(0, len(line) - 1))
    if quote.missing:
        report.add("WMS102", 'a `"` is missing here', Span(source, at, at + 1), "a text stands between two on one line")
    else:
        report.add("WMS102", 'this `"` is one too many', Span(source, at, at + 1), "remove it")
    return [*before, *quote.words, *after]


def _over_lines(source: Source, tokens: list[Token], i: int, report: Report) -> list[Token] | None:
    """The words with a text that is closed on one of the next lines; None if it rather is not."""
    words = unbroken(source.text, tokens, i)
    if words is not None:
        remedy = 'close it on its line; a question may go on in the next: `"..." "..."`'
        report.add("WMS102", "a text ends on the line where it begins", _span(source, tokens[i]), remedy)
    return words


def _as_text(tokens: list[Token], i: int, source: Source, report: Report) -> list[Token]:
    """The words with a text from the quote to the end of its line, but for brackets there."""
    token = tokens[i]
    report.add("WMS102", "this text has no closing quote on its line", _span(source, token), 'close it with `"`')
    text = token.text.rstrip(" \t{)],")
    rest = [t for t in read(token.text[len(text) :], token.start + len(text)) if t.type != "WHITE"]
    rest = [t._replace(line=token.line) for t in rest]
    return [*tokens[:i], token._replace(type="STRING", text=f'{text}"'), *rest, *tokens[i + 1 :]]


def _span(source: Source, token: Token) -> Span:
    return Span(source, token.start, token.end)


def _complain(source: Source, tokens: list[Token], i: int, wanted: set[str], report: Report) -> None:
    token, span = tokens[i], _span(source, tokens[i])
    message = f"`{shown(token)}` is unexpected here"
    if i and tokens[i - 1].type == "STRING":
        wanted = wanted - {"STRING"}  # another piece of a text is never what is missing
    expected = [SPOKEN[t] for t in sorted(wanted & SPOKEN.keys())]
    hint = f"expected {' or '.join(expected)}" if len(expected) in (1, 2, 3) else ""
    if token.type == END:
        span = _span(source, tokens[i - 1]) if i else span
        message = "the file ends too early"
    if "RBRACE" in wanted and (token.type == END or token.type in tables().starters):
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
