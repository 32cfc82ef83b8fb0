"""A question as a row of a table, its pictures as PNG in the layout that Hugging Face `datasets` decodes."""

from __future__ import annotations

import io
import json
from collections.abc import Iterable
from typing import Any

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray
from PIL import Image

from wmspec.ask.model import Asked, Change, Option, Picture
from wmspec.check.ir import Choices, Factor

Row = dict[str, Any]

_IMAGES = pa.list_(pa.struct([("bytes", pa.binary()), ("path", pa.string())]))
_TEXTS = pa.list_(pa.string())
_READINGS = pa.list_(pa.struct([("name", pa.string()), ("value", pa.float64())]))
_PICKS = pa.list_(pa.struct([("engine", pa.string()), ("answer", pa.int64())]))

#: What every row says, whatever the task: the column's type and what it holds.
COLUMNS: dict[str, tuple[pa.DataType, str]] = {
    "id": (pa.string(), "task/index/question/engine, the same in every dataset made with this seed"),
    "task": (pa.string(), "the task"),
    "dimension": (pa.string(), "what is tested, from broad to narrow"),
    "index": (pa.int64(), "which instance of the task's design"),
    "block": (pa.int64(), "which repetition of the design; instances of a block share their nuisances"),
    "question": (pa.int64(), "which of the task's questions"),
    "engine": (pa.string(), "who executed the episode"),
    "renderer": (pa.string(), "who drew the pictures"),
    "text": (pa.string(), "the question"),
    "context": (_IMAGES, "the pictures shown with the question"),
    "context_camera": (_TEXTS, "the camera of each picture shown"),
    "context_time": (pa.list_(pa.float64()), "the time (s) of each picture shown"),
    "option_text": (_TEXTS, "the options, if they are words; null if they are pictures"),
    "option_image": (_IMAGES, "the options, if they are pictures; empty if they are words"),
    "option_kind": (_TEXTS, "what each option is: truth, label or counterfactual"),
    "option_name": (_TEXTS, "the name of each option: of the label's value or of the counterfactual"),
    "option_change": (_TEXTS, "what each counterfactual changed: its kind, what, from what, to what"),
    "answer": (pa.int64(), "the place (from 0) of the true option"),
    "answer_value": (pa.string(), "the answer, measured on the executed episode, in words"),
    "margin": (pa.float64(), "how far the answer is from turning, in multiples of the margin asked for"),
    "measured": (_READINGS, "quantities measured, in SI units"),
    "agreement": (_PICKS, "the option that each engine's outcome picks"),
    "seed": (pa.int64(), "the seed of the design"),
}

#: `"Sequence"`, because versions of `datasets` before 4 do not know `"List"`, and later ones read both.
_FEATURE = {"_type": "Sequence", "feature": {"_type": "Image"}}


def schema(factors: Iterable[Factor]) -> pa.Schema:
    """The columns of a task: the common ones, then `factor.*`, `group.*` and `nuisance.*`.

    A factor's column is boolean, float64 or string, as its values are; its metadata hold its SI `unit`. `group.f` is
    the key that all instances differing in `f` alone share: the "all but f" groups are one `groupby`.
    """
    fields = [pa.field(name, kind) for name, (kind, _) in COLUMNS.items()]
    varied, drawn = _parted(factors)
    fields += [_column("factor", f) for f in varied]
    fields += [pa.field(f"group.{f.name}", pa.string()) for f in varied]
    fields += [_column("nuisance", f) for f in drawn]
    features = {f.name: _FEATURE for f in fields if f.type == _IMAGES}
    return pa.schema(fields, metadata={"huggingface": json.dumps({"info": {"features": features}})})


def _parted(factors: Iterable[Factor]) -> tuple[list[Factor], list[Factor]]:
    everything = list(factors)
    return [f for f in everything if not f.nuisance], [f for f in everything if f.nuisance]


def _column(sort: str, factor: Factor) -> pa.Field:
    return pa.field(f"{sort}.{factor.name}", _type(factor), metadata={"unit": factor.unit})


def _type(factor: Factor) -> pa.DataType:
    values = factor.domain.values if isinstance(factor.domain, Choices) else (0.0,)
    if all(isinstance(v, bool) for v in values):
        return pa.bool_()
    return pa.string() if any(isinstance(v, str) for v in values) else pa.float64()


def identity(task: str, index: int, question: int, engine: str) -> str:
    """The stable name of a question: `collide/000123/q0/mujoco`."""
    return f"{task}/{index:06d}/q{question}/{engine}"


def encode(asked: Asked) -> Row:
    """The row of a question. Encodes its pictures (a few ms each), so call it where the question was made."""
    return {
        "id": identity(asked.task, asked.index, asked.question, asked.engine),
        "task": asked.task,
        "dimension": asked.dimension,
        "index": asked.index,
        "block": asked.block,
        "question": asked.question,
        "engine": asked.engine,
        "renderer": asked.renderer,
        "text": asked.text,
        "context": [_image(p) for p in asked.context],
        "context_camera": [p.camera for p in asked.context],
        "context_time": [p.time for p in asked.context],
        **_options(asked.options),
        "answer": asked.answer,
        "answer_value": asked.value,
        "margin": asked.margin,
        "measured": [{"name": n, "value": float(v)} for n, v in asked.measured.items()],
        "agreement": [{"engine": e, "answer": a} for e, a in asked.agreement],
        "seed": asked.seed,
        **{f"factor.{n}": v for n, v in asked.factors.items()},
        **{f"group.{n}": v for n, v in asked.groups.items()},
        **{f"nuisance.{n}": v for n, v in asked.nuisances.items()},
    }


def _options(options: tuple[Option, ...]) -> Row:
    texts = [o.text for o in options if o.text is not None]
    pictures = [o.picture for o in options if o.picture is not None]
    if sorted((len(texts), len(pictures))) != [0, len(options)]:
        raise ValueError("the options of a question are either all texts or all pictures")
    return {
        "option_text": texts or None,
        "option_image": [_image(p) for p in pictures],
        "option_kind": [o.kind for o in options],
        "option_name": [o.name for o in options],
        "option_change": [_said(o.change) for o in options],
    }


def _said(change: Change | None) -> str | None:
    if change is None:
        return None
    if change.kind == "without":
        return f"without {change.target}"
    return f"{change.kind} {change.target}: {change.before} -> {change.after}"


def _image(picture: Picture) -> dict[str, bytes | None]:
    return {"bytes": png(picture.rgb), "path": None}


def png(rgb: NDArray[np.uint8]) -> bytes:
    """A picture (h, w, 3) as a PNG file. Compression 1: 2 to 6 ms; the default takes up to 37 ms for a few percent."""
    out = io.BytesIO()
    Image.fromarray(rgb).save(out, "PNG", compress_level=1)
    return out.getvalue()


def table(rows: list[Row], columns: pa.Schema) -> pa.Table:
    """Rows as a table. Raises ValueError if a row has columns that the schema lacks, or lacks some of its own."""
    for row in rows:
        if row.keys() != set(columns.names):
            raise ValueError(f"{row.get('id')} has other columns: {sorted(row.keys() ^ set(columns.names))}")
    return pa.Table.from_pylist(rows, schema=columns)
