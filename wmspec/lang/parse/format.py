"""Formatter of specs: it sets spaces, indents and columns, and keeps most line breaks of the author.

Every statement begins a line. A block stays on one line if it was written so and fits; otherwise properties that share
a line keep sharing it. Consecutive lines of one kind are aligned in columns. At most one blank line is kept. Tokens and
comments keep their text and order, which is verified at the end.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from wmspec.core.diagnostics import Report
from wmspec.core.places import Source
from wmspec.lang.parse.columns import FormattedCell, FormattedLine, align_columns
from wmspec.lang.parse.layout import INDENT, Layout, token_text
from wmspec.lang.parse.lexer import Token
from wmspec.lang.parse.parser import parse, tokens_and_comments

#: Maximum length (characters) of a block on one line.
WIDTH = 120


def format_spec(source: Source) -> str:
    """Return the formatted text of a spec. Raises SpecError if it cannot be parsed."""
    report = Report()
    file = parse(source, report)
    report.stop_if_failed()
    tokens = tokens_and_comments(source.text)
    formatted = align_columns(_lines(tokens, Layout(tokens, file.items, WIDTH)), WIDTH)
    assert _significant_tokens(tokens_and_comments(formatted)) == _significant_tokens(tokens), (
        "the formatter may change nothing but spaces"
    )
    return formatted


def _significant_tokens(tokens: list[Token]) -> list[tuple[str, str]]:
    return [(token.type, token_text(token)) for token in tokens]


def _lines(tokens: list[Token], layout: Layout) -> Iterator[FormattedLine]:
    within = _within_statement(tokens, layout)
    first = level = depth = 0
    line = FormattedLine(0, ())
    for i, token in enumerate(tokens):
        if i and not _begins_line(tokens, i, layout):
            continue
        if i:
            yield _fill_cells(line, tokens, first, i, layout)
        level += sum(t.start in layout.opens for t in tokens[first:i]) - (token.start in layout.closes)
        depth += sum(_depth(t) for t in tokens[first:i])
        if within[i]:
            line = FormattedLine(INDENT * (level + (depth + min(_depth(token), 0) or 2)), ())
        else:
            hang = layout.hangs.get(token.start, 0)
            line = FormattedLine(
                INDENT * level + hang, (), blank=i > 0 and not hang and _blank_before(tokens, i, layout)
            )
        first = i
    if tokens:
        yield _fill_cells(line, tokens, first, len(tokens), layout)


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
    """Whether the author left a blank line before this line, except at the start or end of a block."""
    first, last = tokens[i - 1].start in layout.opens, tokens[i].start in layout.closes
    return _rows_between(tokens[i - 1], tokens[i]) > 1 and not first and not last


def _within_statement(tokens: list[Token], layout: Layout) -> list[bool]:
    """Return for each token whether a line that begins with it continues the statement of the previous line."""
    within = [False] * len(tokens)
    following = False
    for i in range(len(tokens) - 1, -1, -1):
        if tokens[i].type != "COMMENT":
            following = not layout.begins_line(tokens[i])
        within[i] = following
    return within


def _fill_cells(line: FormattedLine, tokens: list[Token], first: int, end: int, layout: Layout) -> FormattedLine:
    """Return the line with its cells: tokens `first` to `end`, without a trailing comment."""
    comment = tokens[end - 1].type == "COMMENT"
    cells: list[FormattedCell] = []
    for i in range(first, end - comment):
        sort, text = layout.cells.get(tokens[i].start, ""), token_text(tokens[i])
        if not cells:
            cells.append(FormattedCell(text, sort))
        elif sort:
            cells.append(FormattedCell(text, sort, layout.gap(i)))
        else:
            cells[-1] = replace(cells[-1], text=cells[-1].text + layout.gap(i) + text)
    return replace(line, cells=tuple(cells), comment=token_text(tokens[end - 1]) if comment else "")
