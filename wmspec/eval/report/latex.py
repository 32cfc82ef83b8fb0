"""Tables in LaTeX that fit a column of text: rows of tasks, columns of systems, intervals in small print.

A table with more systems than fit is cut into blocks, one below the other. Packages: booktabs, graphicx.
"""

from __future__ import annotations

import re
from collections.abc import Iterator

import pandas as pd

from wmspec.eval.report.frames import format_percent
from wmspec.eval.report.intervals import Estimate
from wmspec.eval.report.tables import CHANCE, Line, Table

#: Characters of footnotesize that fit a column of 8.4 cm; longest heading that is not turned; longest label of a row.
MAX_WIDTH, MAX_HEADING, MAX_LABEL = 56, 7, 22
_INTERVAL = re.compile(r"(?P<value>[^\[(]*?)\s*(?P<interval>\[[^\]]*\])?\s*(?P<null>\([^)]*\))?")


def accuracy_frame(table: Table) -> pd.DataFrame:
    """Return accuracies in percent with intervals: a row for each average and task, a column for each system."""
    rows = {"all": [_with_interval(line.average) for line in _lines(table)]}
    for dimension in table.dimensions:
        rows[f"all of {dimension}"] = [_of_dimension(line, dimension) for line in _lines(table)]
    for column in table.columns:
        label = f"{column.letters} {column.task}" if column.environment else column.task
        rows[label] = [_with_interval(line.tasks[column.task]) for line in _lines(table)]
    return pd.DataFrame.from_dict(rows, orient="index", columns=[line.system for line in _lines(table)])


def _lines(table: Table) -> tuple[Line, ...]:
    return (*table.lines, table.chance)


def _of_dimension(line: Line, dimension: str) -> str:
    return _with_interval(line.dimensions[dimension]) if dimension in line.dimensions else "–"


def _with_interval(estimate: Estimate) -> str:
    value = format_percent(estimate.value)
    return f"{value} [{format_percent(estimate.low)}, {format_percent(estimate.high)}]" if estimate.sure else value


def latex_table(caption: str, frame: pd.DataFrame) -> str:
    """Return a table in LaTeX. Special characters are escaped, because names of models are untrusted."""
    blocks = [_tabular(frame, block) for block in _blocks(frame)]
    body = "\n\\par\\medskip\n".join(blocks)
    head = "\\begin{table}\n\\centering\\footnotesize\\setlength{\\tabcolsep}{3pt}"
    return f"{head}\n\\caption{{{escape_latex(caption)}}}\n{body}\n\\end{{table}}\n"


def _blocks(frame: pd.DataFrame) -> Iterator[list[int]]:
    """Yield the positions of columns that fit beside the labels."""
    room = MAX_WIDTH - min(MAX_LABEL, max((len(str(label)) for label in frame.index), default=0))
    block: list[int] = []
    used = 0
    for j in range(frame.shape[1]):
        width = max(map(_width, frame.iloc[:, j]), default=3) + 2
        if block and used + width > room:
            yield block
            block, used = [], 0
        block.append(j)
        used += width
    if block:
        yield block


def _width(cell: str) -> int:
    """Return the width of a cell in characters; what is in brackets is on a line of its own, in smaller print."""
    match = _INTERVAL.fullmatch(cell)
    if match is None:
        return len(cell)
    small = max(len(match["interval"] or ""), len(match["null"] or ""))
    return max(len(match["value"]), round(0.6 * small))


def _tabular(frame: pd.DataFrame, block: list[int]) -> str:
    heads = [_heading(str(frame.columns[j])) for j in block]
    lines = [" & ".join(["", *heads]), *(_row(frame, i, block) for i in range(len(frame)))]
    rule = " \\\\\n"
    top, *rest = lines
    return (
        f"\\begin{{tabular}}{{l{'c' * len(block)}}}\n\\toprule\n{top}{rule}\\midrule\n"
        f"{''.join(line + rule for line in rest)}\\bottomrule\n\\end{{tabular}}"
    )


def _heading(name: str) -> str:
    shown = escape_latex(name)
    return shown if len(name) <= MAX_HEADING or name == CHANCE else f"\\rotatebox{{60}}{{{shown}}}"


def _row(frame: pd.DataFrame, i: int, block: list[int]) -> str:
    label = str(frame.index[i])
    shown = escape_latex(label)
    if len(label) > MAX_LABEL:
        shown = f"\\parbox[t]{{3.2cm}}{{\\raggedright {shown}}}"
    return " & ".join([shown, *(_cell(str(frame.iloc[i, j])) for j in block)])


def _cell(text: str) -> str:
    match = _INTERVAL.fullmatch(text)
    if match is None or not (match["interval"] or match["null"]):
        return escape_latex(text)
    small = [f"{{\\tiny {escape_latex(part)}}}" for part in (match["interval"], match["null"]) if part]
    lines = r" \\ ".join([escape_latex(match["value"]), *small])
    return rf"\shortstack{{{lines}}}"


def escape_latex(text: str) -> str:
    """Return a text with the special characters of LaTeX escaped."""
    return text.translate(_LATEX).replace(" · ", r" $\cdot$ ")


_LATEX = str.maketrans(
    {c: f"\\{c}" for c in "_%&#${}"}
    | {"\\": r"\textbackslash{}", "~": r"\textasciitilde{}", "^": r"\textasciicircum{}", "–": "--", "−": "$-$"}
    | {"Δ": r"$\Delta$", "′": "$'$", "α": r"$\alpha$"}
)
