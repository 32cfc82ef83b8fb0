"""Checks that need no engine: every row's place, and what follows from spec, seed and index or is said twice."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any

import pyarrow as pa

from wmspec.compile.design.design import Design, Instance
from wmspec.core.limits import MAX_DRAWS
from wmspec.dataset.build import files
from wmspec.dataset.build.identity import identity
from wmspec.dataset.build.plan import Plan, Shard
from wmspec.dataset.build.reader import DatasetReader
from wmspec.dataset.build.rows import Row, schema
from wmspec.dataset.build.shards import Record
from wmspec.dataset.verify.compare import equal_values
from wmspec.dataset.verify.model import Difference
from wmspec.runtime.questions.ask import answer_slot, groups, names_of
from wmspec.runtime.questions.model import Rejected

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


@dataclass(frozen=True)
class PlannedQuestion:
    """A question of the plan: its task, instance and id."""

    task: str
    index: int
    id: str


@dataclass
class Records:
    """What the folder holds: the record of each shard by path, the kept and rejected questions, the differences."""

    shards: dict[str, Record] = field(default_factory=dict)
    kept: list[PlannedQuestion] = field(default_factory=list)
    rejected: dict[PlannedQuestion, Rejected] = field(default_factory=dict)
    differences: list[Difference] = field(default_factory=list)


def check_records(dataset: DatasetReader, plan: Plan) -> Records:
    """Check every row and rejection against the plan, without an engine. Raises WmsError if a shard cannot be read."""
    found = Records(differences=list(_plan_differences(plan)))
    lost: dict[str, list[Rejected]] = {}
    for one in (Rejected(**record) for record in dataset.manifest["rejected"]["list"]):
        engine = one.engine if plan.rows_of == "engines" else None
        lost.setdefault(identity(plan.seed, one.task, one.index, one.question, engine), []).append(one)
    designs = {task.spec.name: Design(task.spec, plan.seed) for task in plan.tasks}
    for shard in plan.shards():
        _check_shard(dataset, plan, shard, designs[shard.task.spec.name], lost, found)
    for left in lost.values():
        words = f"rejects question {left[0].question} of instance {left[0].index} of {left[0].task} in vain or twice"
        found.differences.append(Difference(files.MANIFEST, "rejected", words))
    return found


def _plan_differences(plan: Plan) -> Iterator[Difference]:
    """Yield the tasks whose instances are not those that specs and seed select."""
    for task in plan.tasks:
        design, count = Design(task.spec, plan.seed), task.selected if task.selected is not None else len(task.indices)
        try:
            expected = design.selection(count, *plan.part, plan.split.contains(design) if plan.split else None)
        except IndexError as error:
            yield Difference(files.MANIFEST, "part", str(error))
            continue
        if task.indices != expected:
            wrong = sorted({*expected} ^ {*task.indices})
            words = f"instance {wrong[0]} of {task.spec.name} is {'missing' if wrong[0] in expected else 'added'}"
            text = words if wrong else f"the instances of {task.spec.name} are in another order"
            yield Difference(files.MANIFEST, "tasks", text)


def _check_shard(
    dataset: DatasetReader,
    plan: Plan,
    shard: Shard,
    design: Design,
    lost: dict[str, list[Rejected]],
    found: Records,
) -> None:
    """Check the rows of a shard, and move its rejections from `lost` to `found`."""
    rows: list[Row] = []
    digest = ""
    if shard.path in dataset.manifest["shards"]:
        there, expected = dataset.shard_schema(shard.path), schema(shard.task.spec, plan.film is not None)
        if not _equal_columns(there, expected):
            found.differences.append(Difference(shard.path, "", "has other columns, units or metadata than its spec"))
        columns = [name for name in there.names if name in COLUMNS or name.startswith(PREFIXES)]
        rows = list(dataset.shard_rows(shard.path, columns))
        digest = files.digest(dataset.folder / shard.path)
    per_engine, rejected = plan.rows_of == "engines", list[Rejected]()
    planned = list(_planned(plan, shard))
    counts, first = Counter(row["id"] for row in rows), {row["id"]: row for row in reversed(rows)}
    for question in planned:
        row, lost_here = first.get(question.id), lost.pop(question.id, [])
        if (fault := _fault(counts[question.id], len(lost_here))) is not None:
            found.differences.append(Difference(question.id, "", fault))
        if row is not None:
            found.kept.append(question)
            found.differences += row_differences(design, row, per_engine)
        elif lost_here:
            found.rejected[question] = lost_here[0]
        rejected += lost_here
    known = {question.id for question in planned}
    found.differences += [Difference(i, "", "is no question of these specs and seed") for i in counts if i not in known]
    found.differences += _misplaced([row["id"] for row in rows], [question.id for question in planned])
    films = dataset.manifest["shards"].get(shard.path, {}).get("films", {})
    found.shards[shard.path] = Record(plan.fingerprint, digest, len(rows), tuple(rejected), dict(sorted(films.items())))


def _fault(rows: int, rejections: int) -> str | None:
    """Return why a question is not exactly one row or one rejection, or None."""
    if rows + rejections == 1:
        return None
    if not rows + rejections:
        return "is missing: neither a row nor a rejection"
    return f"is {rows} rows and {rejections} rejections"


def _misplaced(there: Sequence[str], planned: Sequence[str]) -> Iterator[Difference]:
    """Yield the first row that is not in its place among the planned ones."""
    known, present = set(planned), set(there)
    here = list(dict.fromkeys(i for i in there if i in known))
    for a, b in zip(here, (i for i in planned if i in present), strict=True):
        if a != b:
            yield Difference(a, "", f"is in the place of {b}")
            return


def _planned(plan: Plan, shard: Shard) -> Iterator[PlannedQuestion]:
    """Yield the questions of a shard in the order of its rows."""
    task = shard.task.spec.name
    for index in shard.indices:
        for engine in plan.row_engines:
            for q in range(len(shard.task.spec.questions)):
                yield PlannedQuestion(task, index, identity(plan.seed, task, index, q, engine))


def _equal_columns(there: pa.Schema, expected: pa.Schema) -> bool:
    """Whether two schemas have the same columns, types and metadata; Parquet names the items of lists its own way."""
    metadata = [[schema.metadata, *(field.metadata for field in schema)] for schema in (there, expected)]
    return bool(there.equals(expected)) and metadata[0] == metadata[1]
