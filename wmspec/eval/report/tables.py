"""The tables of perception and prediction: models as rows, tasks as columns, averages as the paper takes them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import pandas as pd

from wmspec.core import wm_abench
from wmspec.eval.report.intervals import Estimate, Floats, estimate, means
from wmspec.eval.report.replies import PEOPLE, Replies

#: What the row is called that says what guessing yields.
CHANCE = "chance"


@dataclass(frozen=True)
class Column:
    """A column of a table: a task, under its dimension; `letters` and `environment` as the paper heads it, if so."""

    task: str
    dimension: str
    letters: str
    environment: str

    @classmethod
    def of(cls, task: str, dimension: str) -> Column:
        """The column of a task by its name and its dimension, such as `perception.space.relation`."""
        parts = [*dimension.split("."), "", ""]
        there = wm_abench.column(task)
        return cls(task, parts[1] or parts[0], there.letters if there else parts[2], there.environment if there else "")


@dataclass(frozen=True)
class Line:
    """A row of a table: of each task the accuracy, of each dimension and of the whole the average (0 to 1).

    `parsed` is the average if replies without an answer are skipped instead of being wrong.
    """

    system: str
    tasks: dict[str, Estimate]
    dimensions: dict[str, Estimate]
    average: Estimate
    parsed: float


@dataclass(frozen=True)
class Table:
    """Of all tasks of one kind (perception, prediction): the columns in order, a line for each system, and chance."""

    kind: str
    columns: tuple[Column, ...]
    lines: tuple[Line, ...]
    chance: Line

    @property
    def dimensions(self) -> tuple[str, ...]:
        """The dimensions in order."""
        return tuple(dict.fromkeys(c.dimension for c in self.columns))


def tables(replies: Replies) -> tuple[Table, ...]:
    """A table for each kind of task: perception, prediction, then others."""
    kind = replies.asked["dimension"].str.split(".").str[0]
    order = {"perception": 0, "prediction": 1}
    return tuple(_table(replies, k, kind == k) for k in sorted(kind.unique(), key=lambda k: (order.get(k, 2), k)))


def average(values: Mapping[str, float], dimension: Mapping[str, str]) -> float:
    """The paper's average: the mean over dimensions of the plain mean of their columns.

    `values` by column, NaN where there is none: such a column is left out, and a dimension that has no other.
    """
    columns = pd.Series(values, dtype=float).dropna()
    return float(columns.groupby([dimension[c] for c in columns.index]).mean().mean()) if len(columns) else np.nan


def _table(replies: Replies, kind: str, chosen: pd.Series[bool]) -> Table:
    asked = replies.asked[chosen]
    columns = tuple(
        sorted({Column.of(t, d) for t, d in zip(asked["task"], asked["dimension"], strict=True)}, key=_place)
    )
    values: dict[str, tuple[Estimate, ...]] = {}
    draws: dict[str, Floats] = {}
    skipping: dict[str, Floats] = {}
    guessed: dict[str, float] = {}
    for column in columns:
        of_task = asked[asked["task"] == column.task]
        scores = replies.scores.loc[of_task.index].to_numpy()
        values[column.task], draws[column.task] = means(scores, of_task["cluster"], column.task)
        parsed = replies.parsed_scores.reindex(of_task.index)
        skipping[column.task] = parsed.mean().to_numpy()
        guessed[column.task] = float((1 / of_task["options"].where(of_task["options"] > 0)).mean())
    lines = [
        _line(
            system,
            columns,
            {t: v[i] for t, v in values.items()},
            {t: d[:, i] for t, d in draws.items()},
            {t: float(s[i]) for t, s in skipping.items()},
        )
        for i, system in enumerate(replies.systems)
    ]
    lines.sort(key=lambda line: (line.system == PEOPLE, -np.nan_to_num(line.average.value)))
    chance = {t: Estimate(v, None, None, values[t][0].questions) for t, v in guessed.items()}
    return Table(kind, columns, tuple(lines), _line(CHANCE, columns, chance, {}, guessed))


def _place(column: Column) -> tuple[int, str, str, str]:
    """Where a column stands: in the paper's order, those that it lacks after them, dimension by dimension."""
    there = wm_abench.column(column.task)
    known = {"space": 0, "time": 1, "vision": 2, "motion": 3, "quantity": 4}
    known |= {"mechanistic": 0, "transitivity": 1, "compositionality": 2}
    within = f"{wm_abench.COLUMNS.index(there):03}" if there else f"~{column.letters}"
    return known.get(column.dimension, 9), column.dimension, within, column.task


def _line(
    system: str,
    columns: tuple[Column, ...],
    values: dict[str, Estimate],
    draws: dict[str, Floats],
    skipping: dict[str, float],
) -> Line:
    """A row, with its averages. Only columns that have a value are averaged, in draws as in values."""
    dimension = {c.task: c.dimension for c in columns if not np.isnan(values[c.task].value)}
    point = {t: values[t].value for t in dimension}
    by_dimension = {
        d: _averaged({t: v for t, v in point.items() if dimension[t] == d}, dimension, values, draws)
        for d in dict.fromkeys(dimension.values())
    }
    whole = _averaged(point, dimension, values, draws)
    return Line(system, values, by_dimension, whole, average({t: skipping[t] for t in dimension}, dimension))


def _averaged(
    point: dict[str, float], dimension: dict[str, str], values: dict[str, Estimate], draws: dict[str, Floats]
) -> Estimate:
    questions = sum(values[t].questions for t in point)
    value = average(point, dimension)
    if not point or not draws or not all(values[t].sure for t in point):
        return Estimate(value, None, None, questions)
    by_dimension: dict[str, list[Floats]] = {}
    for task in point:
        by_dimension.setdefault(dimension[task], []).append(draws[task])
    drawn = np.mean([np.mean(of_one, 0) for of_one in by_dimension.values()], 0)
    return estimate(value, drawn, questions, 10**9)
