"""The questions of a dataset as needed by a report: everything but pictures."""

from __future__ import annotations

import json
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import pandas as pd

from wmspec.dataset.build.reader import DatasetReader
from wmspec.dataset.build.rows import Row
from wmspec.eval.report.named import look_of, object_named, properties, true_properties
from wmspec.runtime.questions.model import HYPOTHETICAL

_COLUMNS = (
    "id", "task", "dimension", "index", "question", "question_name", "engine", "text", "option_text", "option_kind",
    "option_name", "option_change", "answer", "answer_value", "difference", "context_objects",
)  # fmt: skip


@dataclass(frozen=True)
class Questions:
    """The questions of a dataset.

    `table` has a row for each, by id: `task`, `index`, `question`, `engine`, `text`, `options` (number), `kinds`,
    `names` and `changes` of the options (tuples), `levels` of each option by dimension, `truth`, `query`, and
    `quantity`, `unit` and `difference` of the stimulus. `truth` is equal for two questions of a control group exactly
    if they have the same answer; empty if unknown. A `query` is a companion question of a prediction task, about
    visible facts.

    `varied` has the factor and nuisance values of a task's questions, and `object color`, shape and material of the one
    that each is about; `groups` has the keys of their control groups: tables by id, with a column for each factor.
    `about` has the dimension of each factor and nuisance of a task, as the dataset records it. `named` has the names of
    levels that have names.
    """

    table: pd.DataFrame
    varied: dict[str, pd.DataFrame]
    groups: dict[str, pd.DataFrame]
    about: dict[str, dict[str, str]] = field(default_factory=dict)
    named: dict[str, pd.DataFrame] = field(default_factory=dict)

    def levels_of(self, task: str) -> pd.DataFrame:
        """Return the levels of a task's factors by question, by name where values have names."""
        levels = self.varied[task].copy()
        for name, values in self.named.get(task, pd.DataFrame()).items():
            levels[name] = values
        return levels

    @classmethod
    def read(cls, folder: Path) -> Questions:
        """Read a dataset. Raises WmsError if the folder holds no finished dataset, or a file cannot be read."""
        dataset = DatasetReader.open(folder)
        rows = {task: _rows(dataset, task) for task in dataset.tasks}
        return cls(
            _table([row for of_task in rows.values() for row in of_task]),
            {task: _varied(of_task) for task, of_task in rows.items() if of_task},
            {task: _columns_with_prefix(of_task, "group") for task, of_task in rows.items() if of_task},
            {task: _dimensions(dataset, task) for task in dataset.tasks},
            {task: _columns_with_prefix(of_task, "level") for task, of_task in rows.items() if of_task},
        )


def _dimensions(dataset: DatasetReader, task: str) -> dict[str, str]:
    """Return the dimension of every factor and nuisance of a task by name; empty for datasets that record none."""
    declared = {column.split(".", 1)[1]: about for column, about in dataset.dimensions(task).items()}
    return declared | {f"object {name}": name for name in ("color", "shape", "material")}


def _varied(rows: list[Row]) -> pd.DataFrame:
    table = _columns_with_prefix(rows, "factor", "nuisance")
    looks = pd.DataFrame([look_of(row) for row in rows], index=table.index, dtype=object)
    return table.join(looks.rename(columns=lambda name: f"object {name}"))


def _rows(dataset: DatasetReader, task: str) -> list[Row]:
    varied = ("factor.", "group.", "nuisance.", "level.")
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
        "levels": _option_levels(row),
        "truth": _truth(row),
        "quantity": strength["name"],
        "unit": strength["unit"],
        "difference": strength["value"],
    }


def _truth(row: Row) -> str:
    """Return the key of the true answer: the object named, the words, or what a picture's counterfactuals changed.

    "the red cube" and "the blue cube" are the same answer if they name the same object, painted otherwise.
    """
    if row["option_text"] is not None:
        objects = [o for o in row.get("context_objects") or () if o["picture"] == 0]
        words = row["option_text"][row["answer"]] if row["answer"] is not None else ""
        name = object_named(words, objects)
        return f"object {name}" if name else str(row["answer_value"])
    was = {c.split(" -> ")[0] for c in row["option_change"] or () if c and " -> " in c}
    return "; ".join(sorted(was))


def _option_levels(row: Row) -> tuple[dict[str, str], ...]:
    """Return the levels of each option by dimension (see `wmspec.eval.report.named.properties`)."""
    changes = row["option_change"] or (None,) * len(row["option_kind"] or ())
    if row["option_text"] is not None:
        return tuple(properties(words, None) for words in row["option_text"])
    true = true_properties(changes)
    return tuple(true | properties(None, change) for change in changes)


def _columns_with_prefix(rows: list[Row], *sorts: str) -> pd.DataFrame:
    """Return the columns with some prefixes, without those that are empty everywhere; lists become text."""
    names = [key for key in rows[0] if key.split(".", 1)[0] in sorts and "." in key]
    values = {name.split(".", 1)[1]: [_level(row[name]) for row in rows] for name in names}
    return pd.DataFrame(values, index=pd.Index([row["id"] for row in rows], name="id"), dtype=object)


def _level(value: Any) -> Any:
    return json.dumps(value) if isinstance(value, list) else value
