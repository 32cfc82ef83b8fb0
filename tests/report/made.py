"""A dataset of drawn questions, and raters whose weaknesses are known because they were put there."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq

from wmspec.compile.design.design import Design
from wmspec.core.diagnostics import Report
from wmspec.dataset.build.columns import COLUMNS
from wmspec.dataset.build.dataset import Dataset
from wmspec.dataset.build.identity import identity
from wmspec.dataset.build.images import encode_png
from wmspec.dataset.build.plan import Plan, Task
from wmspec.dataset.build.reader import DatasetReader
from wmspec.dataset.build.rows import Row, schema
from wmspec.eval.report.intervals import seeded_generator
from wmspec.lang.check.ir.ir import TaskSpec
from wmspec.lang.check.statements.task import check
from wmspec.runtime.questions.ask import groups

SPECS = Path(__file__).parent / "specs"
TASKS = ("race", "roll", "tally")
TONES = {"red": (200, 50, 50), "green": (50, 160, 80), "blue": (50, 90, 200), "yellow": (220, 190, 50)}

#: An option: its kind, its name, what it changed.
Offered = tuple[str, str, str | None]

#: Results as `wmspec evaluate` writes them.
SCHEMA = pa.schema([
    ("id", pa.string()), ("task", pa.string()), ("dimension", pa.string()), ("question_name", pa.string()),
    ("engine", pa.string()), ("index", pa.int64()), ("block", pa.int64()), ("group", pa.string()),
    ("model", pa.string()), ("model_version", pa.string()), ("prompt", pa.string()), ("prompt_hash", pa.string()),
    ("ablation", pa.string()), ("permutation", pa.int64()), ("sample", pa.int64()), ("order", pa.list_(pa.int64())),
    ("answer", pa.int64()), ("text", pa.string()), ("parsed", pa.int64()), ("number", pa.float64()),
    ("right", pa.bool_()), ("status", pa.string()), ("error", pa.string()), ("tokens_in", pa.int64()),
    ("tokens_out", pa.int64()), ("cost", pa.float64()), ("seconds", pa.float64()),
])  # fmt: skip


# ---------------------------------------------------------------- the dataset


@cache
def spec(name: str) -> TaskSpec:
    report = Report()
    tasks = check(SPECS / f"{name}.wms", report)
    assert tasks, report
    return tasks[0]


def dataset(folder: Path, count: int | None = None, engines: tuple[str, ...] = ("mujoco",)) -> Path:
    """A finished dataset: `count` instances of each task, all of them without."""
    designs = {name: Design(spec(name), 3) for name in TASKS}
    indices = {n: tuple(sorted(d.sample(count))) if count else tuple(range(len(d))) for n, d in designs.items()}
    plan = Plan(
        texts={f"{n}.wms": (SPECS / f"{n}.wms").read_text() for n in TASKS},
        tasks=tuple(Task(spec(n), indices[n]) for n in TASKS),
        engines=engines,
        size=(16, 16),
        seed=3,
        consensus="all",
        rows_of="engines",
        versions={"wmspec": "0.1.0"},
    )
    with Dataset.open(folder, plan, force=True) as made:
        for shard in made.pending():
            design = designs[shard.task.spec.name]
            made.write(shard, [row for i in shard.indices for e in engines for row in question_rows(design, i, e)], ())
        made.finish()
    return folder


def question_rows(design: Design, index: int, engine: str) -> Iterable[Row]:
    """Every question of an instance, as a row. The true option's place is drawn."""
    instance, spec = design[index], design.spec
    picture = {"bytes": encode_png(np.full((16, 16, 3), TONES[str(instance.factors["color"])], np.uint8)), "path": None}
    for number, question in enumerate(spec.questions):
        options, value, strength = _options(spec.name, question.name, instance.factors)
        options = [options[i] for i in seeded_generator("place", spec.name, index, number).permutation(len(options))]
        pictured = any(kind == "counterfactual" for kind, *_ in options)
        known = dict.fromkeys(COLUMNS) | {
            "id": identity(design.seed, spec.name, index, number, engine), "task": spec.name,
            "dimension": spec.dimension,
            "index": index, "block": instance.block, "question": number, "question_name": question.name,
            "engine": engine, "renderer": engine, "text": f"What of {question.name or spec.name}?",
            "context": [picture], "context_camera": ["front"], "context_time": [0.0],
            "option_text": None if pictured else [name for _, name, _ in options],
            "option_image": [picture] * len(options) if pictured else [],
            "option_kind": [kind for kind, *_ in options], "option_name": [name for _, name, _ in options],
            "option_change": [change for *_, change in options],
            "answer": [kind for kind, *_ in options].index("truth"),
            "answer_value": value, "answer_standing": False, "difference": strength, "measured": [], "agreement": [],
            "seed": design.seed, **{f"factor.{n}": v for n, v in instance.factors.items()},
            **{f"group.{n}": v for n, v in groups(instance).items()},
            **{f"nuisance.{n}": v for n, v in instance.nuisances.items()},
        }  # fmt: skip
        yield dict.fromkeys(schema(spec).names) | known


def _options(task: str, name: str, factors: dict[str, Any]) -> tuple[list[Offered], str, dict[str, Any] | None]:
    if task == "race":
        ratio = factors["ratio"] if factors["faster"] == "upper" else 1 / factors["ratio"]
        strength = {"name": "speed(upper) / speed(lower)", "unit": "", "value": ratio}
        return _labels(str(factors["faster"]), ("upper", "lower")), str(factors["faster"]), strength
    if task == "tally":
        number = f"{factors['n']:.0f}"
        return _labels(number, "4567"), number, {"name": "n", "unit": "", "value": factors["n"]}
    if name == "color":
        return _labels(str(factors["color"]), ("red", "green", "blue")), str(factors["color"]), None
    if name == "moves":
        return _labels("yes", ("yes", "no")), "yes", None
    pace = f"{100 * factors['pace']:.0f} cm/s"
    changed = {"slower": "action push.speed", "faster": "action push.speed", "other": "state ball.size"}
    wrong: list[Offered] = [("counterfactual", n, f"{what}: {pace} -> {n}") for n, what in changed.items()]
    return [("truth", "truth", None), *wrong], "front at 1 s", None


def _labels(truth: str, values: Iterable[str]) -> list[Offered]:
    return [("truth" if v == truth else "label", v, None) for v in values]


# ---------------------------------------------------------------- raters


#: How probable a right answer is, from the row.
Knows = Callable[[Row], float]


@dataclass(frozen=True)
class Rater:
    """Who answers: rightly as probably as `knows` says, else one of the wrong options, as probably as `wrongly`

    says.
    """

    name: str
    knows: Knows
    wrongly: Callable[[Row], list[float]] | None = None
    permutations: int = 1
    status: Callable[[Row], str] = field(default=lambda row: "answered")
    place: int | None = None  # what it chooses by its place as shown where it does not know


def rows(folder: Path) -> list[Row]:
    found = DatasetReader.open(folder)
    return [
        {k: v for k, v in row.items() if k not in ("context", "option_image")}
        for t in found.tasks
        for row in found.rows(t)
    ]


def answers(questions: list[Row], *raters: Rater) -> pd.DataFrame:
    """Their replies, as rows of results."""
    return pd.DataFrame([_reply(r, row, p) for r in raters for row in questions for p in range(r.permutations)])


def _reply(rater: Rater, row: Row, permutation: int) -> Row:
    random = seeded_generator(rater.name, row["id"], permutation)
    kinds, truth, status = row["option_kind"], row["answer"], rater.status(row)
    order = [int(i) for i in np.roll(np.arange(len(kinds)), permutation)]
    wrong = [i for i in range(len(kinds)) if i != truth]
    weights = None if rater.wrongly is None else np.array([rater.wrongly(row)[i] for i in wrong])
    knows = random.random() < rater.knows(row)
    guess = int(random.choice(wrong, p=None if weights is None else weights / weights.sum()))
    guess = guess if rater.place is None else order[rater.place]
    chosen = truth if knows else guess
    reported = status == "answered"
    return {
        **{k: row[k] for k in ("id", "task", "dimension", "question_name", "engine", "index", "block")},
        "group": f"{row['task']}/{row['block']}", "model": rater.name, "model_version": "1", "prompt": "default",
        "prompt_hash": "0", "ablation": "", "permutation": permutation, "sample": 0, "order": order, "answer": truth,
        "text": str(chosen), "parsed": chosen if reported else None, "number": None, "finish_reason": "stop",
        "right": reported and chosen == truth, "status": status, "error": "broken" if status == "error" else None,
        "tokens_in": 100, "tokens_out": 2, "tokens_reasoning": None, "reasoning": None, "cost": 0.001, "seconds": 1.0,
    }  # fmt: skip


def write(path: Path, table: pd.DataFrame) -> Path:
    path.parent.mkdir(parents=True, exist_ok=True)
    pq.write_table(pa.Table.from_pandas(table, schema=SCHEMA, preserve_index=False), path)
    return path
