"""The questions of a dataset as needed by a report: everything but pictures."""

from __future__ import annotations

import json
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import pandas as pd

from wmspec.dataset.build.reader import DatasetReader
from wmspec.dataset.build.rows import Row
from wmspec.runtime.questions.model import HYPOTHETICAL

_COLUMNS = (
    "id", "task", "dimension", "index", "question", "question_name", "engine", "text", "option_text", "option_kind",
    "option_name", "option_change", "answer", "answer_value", "difference",
)  # fmt: skip


@dataclass(frozen=True)
class Questions:
    """The questions of a dataset.

    `table` has a row for each, by id: `task`, `index`, `question`, `engine`, `text`, `options` (number), `kinds`,
    `names` and `changes` of the options (tuples), `truth`, `query`, and `quantity`, `unit` and `difference` of the
    stimulus. `truth` is equal for two questions of a control group exactly if they have the same answer; empty if
    unknown. A `query` is a companion question of a prediction task, about visible facts.

    `varied` has the factor and nuisance values of a task's questions, `groups` the keys of their control groups: tables
    by id, with a column for each factor. `about` has the dimension of each factor and nuisance of a task, as the
    dataset records it.
    """

    table: pd.DataFrame
    varied: dict[str, pd.DataFrame]
    groups: dict[str, pd.DataFrame]
    about: dict[str, dict[str, str]] = field(default_factory=dict)

    @classmethod
    def read(cls, folder: Path) -> Questions:
        """Read a dataset. Raises WmsError if the folder holds no finished dataset, or a file cannot be read."""
        dataset = DatasetReader.open(folder)
        rows = {task: _rows(dataset, task) for task in dataset.tasks}
        return cls(
            _table([row for of_task in rows.values() for row in of_task]),
            {task: _columns_with_prefix(of_task, "factor", "nuisance") for task, of_task in rows.items() if of_task},
            {task: _columns_with_prefix(of_task, "group") for task, of_task in rows.items() if of_task},
            {task: _dimensions(dataset, task) for task in dataset.tasks},
        )


def _dimensions(dataset: DatasetReader, task: str) -> dict[str, str]:
    """Return the dimension of every factor and nuisance of a task by name; empty for datasets that record none."""
    return {column.split(".", 1)[1]: about for column, about in dataset.dimensions(task).items()}


def _rows(dataset: DatasetReader, task: str) -> list[Row]:
    varied = ("factor.", "group.", "nuisance.")
    columns = [c for c in dataset.columns(task) if c in _COLUMNS or c.startswith(varied)]
    return list(dataset.rows(task, columns))


def _table(rows: list[Row]) -> pd.DataFrame:
    table = pd.DataFrame([_question(row) for row in rows]).set_index("id")
    foresees = table["kinds"].map(lambda kinds: not HYPOTHETICAL.isdisjoint(kinds))
    predicts = table["dimension"].str.split(".").str[0] == "prediction"
    table["query"] = predicts & foresees.groupby(table["task"]).transform("any") & ~foresees
    return table


def _question(row: Row) -> dict[str, Any]:
    strength = row["difference"] or {"name": "", "unit": "", "value": float("nan")}
    return {
        **{
            key: row[key] for key in ("id", "task", "dimension", "index", "question", "question_name", "engine", "text")
        },
        "options": len(row["option_kind"] or ()),
        "kinds": tuple(row["option_kind"] or ()),
        "names": tuple(row["option_name"] or ()),
        "changes": tuple(row["option_change"] or ()),
        "truth": _truth(row),
        "quantity": strength["name"],
        "unit": strength["unit"],
        "difference": strength["value"],
    }


def _truth(row: Row) -> str:
    """Return the key of the true answer: the words, or the actual value of what a picture's counterfactuals changed."""
    if row["option_text"] is not None:
        return str(row["answer_value"])
    was = {c.split(" -> ")[0] for c in row["option_change"] or () if c and " -> " in c}
    return "; ".join(sorted(was))


def _columns_with_prefix(rows: list[Row], *sorts: str) -> pd.DataFrame:
    """Return the columns with some prefixes, without those that are empty everywhere; lists become text."""
    names = [key for key in rows[0] if key.split(".", 1)[0] in sorts and "." in key]
    values = {name.split(".", 1)[1]: [_level(row[name]) for row in rows] for name in names}
    return pd.DataFrame(values, index=pd.Index([row["id"] for row in rows], name="id"), dtype=object)


def _level(value: Any) -> Any:
    return json.dumps(value) if isinstance(value, list) else value
