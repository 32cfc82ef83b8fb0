"""The one way to write a spec: spaces, indents and columns are the formatter's, line breaks mostly the author's.

Every statement begins a line. A block stays on one line if it was written so and fits, else the properties that the
author put on one line stay on one. Lines of one kind that follow one another are set in columns. At most one blank line
is kept. Words and comments stay as they are and in their order, which is checked at the end.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from wmspec.core.diagnostics import Report
from wmspec.core.places import Source
from wmspec.lang.parse.columns import Cell, Line, in_columns
from wmspec.lang.parse.layout import INDENT, Layout, spelled
from wmspec.lang.parse.lexer import Token
from wmspec.lang.parse.parser import parse, words

#: The longest line that a block is kept on, in characters.
WIDTH = 120


def format_spec(source: Source) -> str:
    """The formatted text of a spec. Raises SpecError if it cannot be parsed."""
    report = Report()
    file = parse(source, report)
    report.stop_if_failed()
    tokens = words(source.text)
    formatted = in_columns(_lines(tokens, Layout(tokens, file.items, WIDTH)), WIDTH)
    assert _meaning(words(formatted)) == _meaning(tokens), "the formatter may change nothing but spaces"
    return formatted


def _meaning(tokens: list[Token]) -> list[tuple[str, str]]:
    return [(token.type, spelled(token)) for token in tokens]


def _lines(tokens: list[Token], layout: Layout) -> Iterator[Line]:
    within = _within_statement(tokens, layout)
    first = level = depth = 0
    line = Line(0, ())
    for i, token in enumerate(tokens):
        if i and not _begins_line(tokens, i, layout):
            continue
        if i:
            yield _filled(line, tokens, first, i, layout)
        level += sum(t.start in layout.opens for t in tokens[first:i]) - (token.start in layout.closes)
        depth += sum(_depth(t) for t in tokens[first:i])
        if within[i]:
            line = Line(INDENT * (level + (depth + min(_depth(token), 0) or 2)), ())
        else:
            hang = layout.hangs.get(token.start, 0)
            line = Line(INDENT * level + hang, (), blank=i > 0 and not hang and _blank_before(tokens, i, layout))
        first = i
    if tokens:
        yield _filled(line, tokens, first, len(tokens), layout)


def _depth(token: Token) -> int:
    return (token.type in ("LPAR", "LSQB")) - (token.type in ("RPAR", "RSQB"))


def _begins_line(tokens: list[Token], i: int, layout: Layout) -> bool:
    here, before = tokens[i], tokens[i - 1]
    if before.type == "COMMENT" or layout.begins_line(here):
        return True
    return _rows_between(before, here) > 0 and here.type not in ("LBRACE", "RBRACE")


def _rows_between(before: Token, here: Token) -> int:
    return here.line - before.end_line


def _blank_before(tokens: list[Token], i: int, layout: Layout) -> bool:
    """Whether the author left lines empty before a line, other than at the start or end of a block."""
    first, last = tokens[i - 1].start in layout.opens, tokens[i].start in layout.closes
    return _rows_between(tokens[i - 1], tokens[i]) > 1 and not first and not last


def _within_statement(tokens: list[Token], layout: Layout) -> list[bool]:
    """For each token, whether a line that begins with it goes on with the statement of the line before."""
    within = [False] * len(tokens)
    following = False
    for i in range(len(tokens) - 1, -1, -1):
        if tokens[i].type != "COMMENT":
            following = not layout.begins_line(tokens[i])
        within[i] = following
    return within


def _filled(line: Line, tokens: list[Token], first: int, end: int, layout: Layout) -> Line:
    """The line with its cells: tokens `first` to `end`, without the comment that may end them."""
    comment = tokens[end - 1].type == "COMMENT"
    cells: list[Cell] = []
    for i in range(first, end - comment):
        sort, text = layout.cells.get(tokens[i].start, ""), spelled(tokens[i])
        if not cells:
            cells.append(Cell(text, sort))
        elif sort:
            cells.append(Cell(text, sort, layout.gap(i)))
        else:
            cells[-1] = replace(cells[-1], text=cells[-1].text + layout.gap(i) + text)
    return replace(line, cells=tuple(cells), comment=spelled(tokens[end - 1]) if comment else "")
