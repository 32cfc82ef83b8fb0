"""Lines set in columns: a cell is as wide as the widest of its neighbours above and below that are of the same sort."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass


@dataclass(frozen=True)
class Cell:
    """A piece of a line: its text, its sort, and the space before it if it is not the first."""

    text: str
    sort: str
    gap: str = " "


@dataclass(frozen=True)
class Line:
    """A line: its indent, its cells, the comment that ends it, and whether a blank line comes before it."""

    indent: int
    cells: tuple[Cell, ...]
    comment: str = ""
    blank: bool = False

    def follows(self, other: Line, cells: int) -> bool:
        """Whether the first so many cells of this line stand under those of the other, the line before."""
        mine, theirs = ([c.sort for c in line.cells[:cells]] for line in (self, other))
        return (
            mine == theirs and len(mine) == cells and bool(mine[0]) and not self.blank and self.indent == other.indent
        )


def in_columns(lines: Iterable[Line], width: int) -> str:
    """The text of the lines. A column that would make a line longer than `width` is left out."""
    rows = list(lines)
    texts = [text for run in _runs(rows, 1) for text in _aligned(run, width)]
    texts = _commented(rows, texts)
    return "".join(("\n" if row.blank else "") + text + "\n" for row, text in zip(rows, texts, strict=True))


def _runs(rows: list[Line], cells: int) -> list[list[Line]]:
    runs: list[list[Line]] = []
    for i, row in enumerate(rows):
        if i and row.follows(rows[i - 1], cells):
            runs[-1].append(row)
        else:
            runs.append([row])
    return runs


def _aligned(run: list[Line], width: int) -> list[str]:
    """The texts of neighbours, with those columns, from the left, that make none of them too long."""
    widths: list[dict[int, int]] = [{} for _ in run]
    fits = [len(_text(row, {})) <= width for row in run]
    for cell in range(max(len(row.cells) for row in run) - 1):
        first = 0
        for part in _runs(run, cell + 2):
            here = range(first, first + len(part))
            wanted = max(len(row.cells[cell].text) if cell < len(row.cells) else 0 for row in part)
            wider = {i: widths[i] | {cell: wanted} for i in here}
            if all(len(_text(run[i], wider[i])) <= width or not fits[i] for i in here):
                widths[first : first + len(part)] = wider.values()
            first += len(part)
    return [_text(row, w) for row, w in zip(run, widths, strict=True)]


def _text(row: Line, widths: dict[int, int]) -> str:
    text = " " * row.indent
    for i, cell in enumerate(row.cells):
        last = i == len(row.cells) - 1
        text += (cell.gap if i else "") + (cell.text if last else cell.text.ljust(widths.get(i, 0)))
    return text


def _commented(rows: list[Line], texts: list[str]) -> list[str]:
    """The texts with their comments, which stand under one another on lines that follow one another."""
    lines: list[str] = []
    column = 0
    for i, row in enumerate(rows):
        if not row.comment or not row.cells:
            lines.append(texts[i] + row.comment)
            continue
        if not (i and _ends_in_comment(rows[i - 1]) and not row.blank):
            column = max(map(len, _commented_run(rows, texts, i)))
        lines.append(f"{texts[i].ljust(column)}  {row.comment}")
    return lines


def _ends_in_comment(row: Line) -> bool:
    return bool(row.comment and row.cells)


def _commented_run(rows: list[Line], texts: list[str], first: int) -> list[str]:
    last = first + 1
    while last < len(rows) and _ends_in_comment(rows[last]) and not rows[last].blank:
        last += 1
    return texts[first:last]
