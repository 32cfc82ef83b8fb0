"""Column alignment: adjacent cells of the same kind get the width of the widest."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass


@dataclass(frozen=True)
class FormattedCell:
    """A piece of a line: its text, its kind, and the space before it unless it is the first."""

    text: str
    sort: str
    gap: str = " "


@dataclass(frozen=True)
class FormattedLine:
    """A line: its indent, its cells, its trailing comment, and whether a blank line precedes it."""

    indent: int
    cells: tuple[FormattedCell, ...]
    comment: str = ""
    blank: bool = False

    def aligns_with(self, other: FormattedLine, cells: int) -> bool:
        """Whether the first `cells` cells of this line align with those of `other`, the previous line."""
        mine, theirs = ([c.sort for c in line.cells[:cells]] for line in (self, other))
        return (
            mine == theirs and len(mine) == cells and bool(mine[0]) and not self.blank and self.indent == other.indent
        )


def align_columns(lines: Iterable[FormattedLine], width: int) -> str:
    """Return the text of the lines. A column that would make a line longer than `width` is not aligned."""
    rows = list(lines)
    texts = [text for run in _runs(rows, 1) for text in _align(run, width)]
    texts = _add_comments(rows, texts)
    return "".join(("\n" if row.blank else "") + text + "\n" for row, text in zip(rows, texts, strict=True))


def _runs(rows: list[FormattedLine], cells: int) -> list[list[FormattedLine]]:
    runs: list[list[FormattedLine]] = []
    for i, row in enumerate(rows):
        if i and row.aligns_with(rows[i - 1], cells):
            runs[-1].append(row)
        else:
            runs.append([row])
    return runs


def _align(run: list[FormattedLine], width: int) -> list[str]:
    """Return the texts of adjacent lines, aligning columns from the left while every line fits."""
    widths: list[dict[int, int]] = [{} for _ in run]
    fits = [len(_text(row, {})) <= width for row in run]
    for cell in range(max(len(row.cells) for row in run) - 1):
        first = 0
        for part in _runs(run, cell + 2):
            here = range(first, first + len(part))
            width_needed = max(len(row.cells[cell].text) if cell < len(row.cells) else 0 for row in part)
            wider = {i: widths[i] | {cell: width_needed} for i in here}
            if all(len(_text(run[i], wider[i])) <= width or not fits[i] for i in here):
                widths[first : first + len(part)] = wider.values()
            first += len(part)
    return [_text(row, w) for row, w in zip(run, widths, strict=True)]


def _text(row: FormattedLine, widths: dict[int, int]) -> str:
    text = " " * row.indent
    for i, cell in enumerate(row.cells):
        last = i == len(row.cells) - 1
        text += (cell.gap if i else "") + (cell.text if last else cell.text.ljust(widths.get(i, 0)))
    return text


def _add_comments(rows: list[FormattedLine], texts: list[str]) -> list[str]:
    """Return the texts with their comments; comments of consecutive lines are aligned."""
    lines: list[str] = []
    column = 0
    for i, row in enumerate(rows):
        if not row.comment or not row.cells:
            lines.append(texts[i] + row.comment)
            continue
        if not (i and _ends_in_comment(rows[i - 1]) and not row.blank):
            column = max(map(len, _comment_run(rows, texts, i)))
        lines.append(f"{texts[i].ljust(column)}  {row.comment}")
    return lines


def _ends_in_comment(row: FormattedLine) -> bool:
    return bool(row.comment and row.cells)


def _comment_run(rows: list[FormattedLine], texts: list[str], first: int) -> list[str]:
    last = first + 1
    while last < len(rows) and _ends_in_comment(rows[last]) and not rows[last].blank:
        last += 1
    return texts[first:last]
