"""Tables of perception and prediction: models as rows, tasks as columns, averages as in the paper."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import pandas as pd

from wmspec.core import wm_abench
from wmspec.eval.report.intervals import Estimate, Floats, estimate, mean_estimates
from wmspec.eval.report.replies import PEOPLE, Replies

#: The name of the row for guessing.
CHANCE = "chance"


@dataclass(frozen=True)
class Column:
    """A column of a table: a task and its dimension; `letters` and `environment` as in the paper's header."""

    task: str
    dimension: str
    letters: str
    environment: str

    @classmethod
    def of(cls, task: str, dimension: str) -> Column:
        """Return the column of a task by its name and its dimension, such as `perception.space.relation`."""
        parts = [*dimension.split("."), "", ""]
        there = wm_abench.COLUMN_OF_TASK.get(task)
        return cls(task, parts[1] or parts[0], there.letters if there else parts[2], there.environment if there else "")


@dataclass(frozen=True)
class Line:
    """A row of a table: accuracy of each task, average of each dimension and of the whole (0 to 1).

    `parsed` is the average over answered questions alone; the others count as wrong otherwise. `chance` is the average
    of guessing over the columns of this row, `columns` their number.
    """

    system: str
    tasks: dict[str, Estimate]
    dimensions: dict[str, Estimate]
    average: Estimate
    parsed: float
    chance: float
    columns: int


@dataclass(frozen=True)
class Table:
    """The tasks of one kind (perception, prediction): columns in order, a row for each system, and chance."""

    kind: str
    columns: tuple[Column, ...]
    lines: tuple[Line, ...]
    chance: Line

    @property
    def dimensions(self) -> tuple[str, ...]:
        """The dimensions in order."""
        return tuple(dict.fromkeys(c.dimension for c in self.columns))


def tables(replies: Replies) -> tuple[Table, ...]:
    """Return a table for each kind of task: perception, prediction, then others."""
    kind = replies.main_questions["dimension"].str.split(".").str[0]
    order = {"perception": 0, "prediction": 1}
    return tuple(_table(replies, k, kind == k) for k in sorted(kind.unique(), key=lambda k: (order.get(k, 2), k)))


def average(values: Mapping[str, float], dimension: Mapping[str, str]) -> float:
    """Return the paper's average: the mean over dimensions of the mean of their columns.

    `values` by column; NaN columns and dimensions without columns are skipped.
    """
    columns = pd.Series(values, dtype=float).dropna()
    return float(columns.groupby([dimension[c] for c in columns.index]).mean().mean()) if len(columns) else np.nan


def _table(replies: Replies, kind: str, chosen: pd.Series[bool]) -> Table:
    main_questions = replies.main_questions[chosen]
    columns = tuple(
        sorted(
            {Column.of(t, d) for t, d in zip(main_questions["task"], main_questions["dimension"], strict=True)},
            key=_sort_key,
        )
    )
    values: dict[str, tuple[Estimate, ...]] = {}
    draws: dict[str, Floats] = {}
    skipping: dict[str, Floats] = {}
    guessed: dict[str, float] = {}
    for column in columns:
        of_task = main_questions[main_questions["task"] == column.task]
        scores = replies.scores.loc[of_task.index].to_numpy()
        values[column.task], draws[column.task] = mean_estimates(scores, of_task["cluster"], column.task)
        parsed = replies.parsed_scores.reindex(of_task.index)
        skipping[column.task] = parsed.mean().to_numpy()
        guessed[column.task] = float(of_task["chance"].mean())
    lines = [
        _line(
            system,
            columns,
            {t: v[i] for t, v in values.items()},
            {t: d[:, i] for t, d in draws.items()},
            {t: float(s[i]) for t, s in skipping.items()},
            guessed,
        )
        for i, system in enumerate(replies.systems)
    ]
    lines.sort(key=lambda line: (line.system == PEOPLE, -np.nan_to_num(line.average.value)))
    chance = {t: Estimate(v, None, None, values[t][0].questions) for t, v in guessed.items()}
    return Table(kind, columns, tuple(lines), _line(CHANCE, columns, chance, {}, guessed, guessed))


def _sort_key(column: Column) -> tuple[int, str, str, str]:
    """Sort key of a column: the paper's order, then other columns by dimension."""
    there = wm_abench.COLUMN_OF_TASK.get(column.task)
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
    guessed: dict[str, float],
) -> Line:
    """Return a row with its averages over columns that have a value, for the estimate and its draws."""
    dimension = {c.task: c.dimension for c in columns if not np.isnan(values[c.task].value)}
    point = {t: values[t].value for t in dimension}
    by_dimension = {
        d: _average_estimate({t: v for t, v in point.items() if dimension[t] == d}, dimension, values, draws)
        for d in dict.fromkeys(dimension.values())
    }
    whole = _average_estimate(point, dimension, values, draws)
    parsed, chance = (average({t: part[t] for t in dimension}, dimension) for part in (skipping, guessed))
    return Line(system, values, by_dimension, whole, parsed, chance, len(dimension))


def _average_estimate(
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
