"""Checks of a row that need no engine: what follows from spec, seed and index, and what the row says twice."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from wmspec.compile.design.design import Design, Instance
from wmspec.core.limits import MAX_DRAWS
from wmspec.dataset.build.identity import identity
from wmspec.dataset.build.rows import Row
from wmspec.dataset.verify.compare import equal_values
from wmspec.dataset.verify.model import Difference
from wmspec.runtime.questions.ask import answer_slot, groups, names_of

#: The columns that are compared, in addition to those of factors and nuisances.
COLUMNS = (
    "id", "task", "dimension", "index", "block", "crossed", "question", "question_name", "engine", "renderer",
    "option_kind", "answer", "answer_value", "agreement", "seed", "redrawn",
)  # fmt: skip
PREFIXES = ("factor.", "level.", "group.", "nuisance.")


def row_differences(design: Design, row: Row, per_engine: bool) -> Iterator[Difference]:
    """Yield the first difference of a row from its plan, or the first contradiction in it."""
    if not 0 <= row["index"] < len(design) or not 0 <= row["question"] < len(design.spec.questions):
        yield Difference(row["id"], "index", f"there is no question {row['question']} of instance {row['index']}")
        return
    redrawn = row.get("redrawn") or 0
    if not 0 <= redrawn < MAX_DRAWS or (redrawn and not design.spec.plan.balance):
        yield Difference(row["id"], "redrawn", f"{redrawn} in the dataset")
        return
    instance = (design.redrawn(redrawn) if redrawn else design)[row["index"]]
    for name, value in _planned_values(design, instance, row, per_engine).items():
        if name in row and not equal_values(row[name], value):
            yield Difference(row["id"], name, f"{row[name]!r} in the dataset, {value!r} by the spec and seed")
            return
    if fault := _contradiction(design, instance, row):
        yield Difference(row["id"], "answer", fault)


def _planned_values(design: Design, instance: Instance, row: Row, per_engine: bool) -> dict[str, Any]:
    """Return the values of the columns that follow from the plan."""
    spec, q = design.spec, row["question"]
    return {
        "id": identity(design.seed, spec.name, instance.index, q, row["engine"] if per_engine else None),
        "seed": design.seed,
        "dimension": spec.dimension,
        "question_name": spec.questions[q].name,
        "block": instance.block,
        "crossed": list(instance.crossed),
        **{f"factor.{name}": value for name, value in instance.factors.items()},
        **{f"level.{name}": words for name, words in names_of(spec, instance.values).items()},
        **{f"group.{name}": key for name, key in groups(instance).items()},
        **{f"nuisance.{name}": value for name, value in instance.nuisances.items()},
    }


def _contradiction(design: Design, instance: Instance, row: Row) -> str:
    """Return how the answer of a row contradicts the place of the truth or the row's other columns, or ''."""
    kinds, answer = row.get("option_kind") or [], row.get("answer")
    if kinds:
        try:
            place = answer_slot(design, instance, row["question"]).order(0, len(kinds)).index(0)
        except AssertionError:
            return f"{len(kinds)} options in the dataset, which are not the members of the closed set"
        if answer != place:
            return f"{answer} in the dataset, and the seed puts the truth at {place}"
        if kinds[place] != "truth" or kinds.count("truth") != 1:
            return f"{answer}, where `option_kind` is {kinds[place]}"
    own = next((vote for vote in row.get("agreement") or () if vote["engine"] == row["engine"]), None)
    if own is not None and (own["answer"], own["value"]) != (answer, row.get("answer_value")):
        return f"{answer} ({row.get('answer_value')}), and in `agreement` {own['answer']} ({own['value']})"
    return ""
