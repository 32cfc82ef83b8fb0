"""Questions as table rows, with pictures in the layout that Hugging Face `datasets` decodes."""

from __future__ import annotations

import json
from collections.abc import Iterable
from dataclasses import asdict
from typing import Any

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray

from wmspec.compile.design.dimension import dimension
from wmspec.dataset.build.columns import COLUMNS, FILMS, IMAGES, OBJECT_SCALARS, optional_columns
from wmspec.dataset.build.identity import identity
from wmspec.dataset.build.images import encode_png, encode_webp
from wmspec.lang.check.ir.ir import Choices, Factor, TaskSpec
from wmspec.runtime.questions.consensus import RowsOf
from wmspec.runtime.questions.model import Change, Legibility, Picture, QuestionRow, Strength, VisibleObject

Row = dict[str, Any]

#: The film columns of a row without a film.
NO_FILM: Row = {name: [] if pa.types.is_list(kind) else None for name, (kind, _) in FILMS.items()}

#: `"Sequence"`, because versions of `datasets` before 4 do not know `"List"`, and later ones read both.
_FEATURE = {"_type": "Sequence", "feature": {"_type": "Image"}}


def schema(spec: TaskSpec, films: bool = False) -> pa.Schema:
    """Return the columns of a task: common ones, optional ones, then `factor.*`, `level.*`, `group.*`, `nuisance.*`.

    A factor's column is boolean, float64, string, or a list of float64 for points; its metadata hold the SI `unit` and
    the dimension that it is `about`.
    `group.f` is the key shared by all instances that differ in `f` alone, so one `groupby` gives the groups. `level.f`
    is the name of a value of a factor or nuisance with named values.
    """
    varied, drawn = [f for f in spec.factors if not f.nuisance], [f for f in spec.factors if f.nuisance]
    fields = [pa.field(name, kind) for name, (kind, _) in optional_columns(spec, films).items()]
    fields += [_column(spec, "factor", f) for f in varied]
    fields += [pa.field(f"level.{f.name}", pa.string()) for f in (*varied, *drawn) if _has_named_values(f)]
    fields += [pa.field(f"group.{f.name}", pa.string()) for f in varied]
    fields += [_column(spec, "nuisance", f) for f in drawn]
    return table_schema(fields)


def table_schema(more: Iterable[pa.Field]) -> pa.Schema:
    """Return the columns that every dataset has and the given ones, with the metadata of Hugging Face `datasets`."""
    fields = [*(pa.field(name, kind) for name, (kind, _) in COLUMNS.items()), *more]
    features = {f.name: _FEATURE for f in fields if f.type == IMAGES}
    return pa.schema(fields, metadata={"huggingface": json.dumps({"info": {"features": features}})})


def _has_named_values(factor: Factor) -> bool:
    """Whether a factor has named values."""
    return isinstance(factor.domain, Choices) and factor.domain.names is not None


def _column(spec: TaskSpec, sort: str, factor: Factor) -> pa.Field:
    metadata = {"unit": factor.unit, "about": dimension(spec, factor)}
    return pa.field(f"{sort}.{factor.name}", _type(factor), metadata=metadata)


def _type(factor: Factor) -> pa.DataType:
    values = factor.domain.values if isinstance(factor.domain, Choices) else (0.0,)
    if all(isinstance(v, bool) for v in values):
        return pa.bool_()
    if any(isinstance(v, tuple) for v in values):
        return pa.list_(pa.float64())
    return pa.string() if any(isinstance(v, str) for v in values) else pa.float64()


def encode(question: QuestionRow, rows_of: RowsOf, film: Row | None = None) -> Row:
    """Return the row of a question, with its film columns if the dataset has films.

    Encoding pictures takes a few milliseconds each, so call it in the worker.
    """
    engine = question.engine if rows_of == "engines" else None
    return {
        "id": identity(question.seed, question.task, question.index, question.question, engine),
        "task": question.task,
        "dimension": question.dimension,
        "index": question.index,
        "block": question.block,
        "crossed": list(question.crossed),
        "question": question.question,
        "question_name": question.name,
        "engine": question.engine,
        "renderer": question.renderer,
        "text": question.text,
        "context": [encode_picture(p.rgb) for p in question.context],
        "context_camera": [p.camera for p in question.context],
        "context_time": [p.time for p in question.context],
        "context_objects": _objects(question.objects),
        **_options(question),
        "answer": question.answer,
        "answer_value": question.value,
        "answer_number": question.number.value if question.number else None,
        "answer_unit": question.number.unit if question.number else None,
        "answer_within": question.number.within if question.number else None,
        "answer_standing": question.standing,
        "answer_moments": question.moments,
        "difference": _strength(question.difference),
        "margin": question.margin,
        "legibility": [_measure(each) for each in question.legibility],
        "measured": [{"name": n, "value": float(v)} for n, v in question.measured.items()],
        "agreement": [asdict(vote) for vote in question.agreement],
        "seed": question.seed,
        **({} if question.redrawn is None else {"redrawn": question.redrawn}),
        **({} if question.visible is None else {"context_visible": [asdict(each) for each in question.visible]}),
        **_what_ifs(question),
        **_channel_columns(question.context),
        **(film or {}),
        **{f"factor.{n}": v for n, v in question.factors.items()},
        **{f"level.{n}": words for n, words in question.levels.items()},
        **{f"group.{n}": v for n, v in question.groups.items()},
        **{f"nuisance.{n}": v for n, v in question.nuisances.items()},
    }


def _options(question: QuestionRow) -> Row:
    options = question.options
    texts = [o.text for o in options if o.text is not None]
    pictures = [o.picture for o in options if o.picture is not None]
    if (texts and pictures) or len(texts) + len(pictures) != len(options):
        raise ValueError("every option of a question has a text, or every one has a picture")
    return {
        "option_text": None if pictures else texts,
        "option_image": [encode_picture(p.rgb) for p in pictures],
        "option_kind": [o.kind for o in options],
        "option_name": [o.name for o in options],
        "option_change": [_change(o.change) for o in options],
        "option_objects": _objects([o.objects for o in options]),
        **({"option_outcome": [o.outcome for o in options]} if question.sorted_outcomes else {}),
    }


def _what_ifs(question: QuestionRow) -> Row:
    if question.what_ifs is None:
        return {}
    return {"what_if": [_change(each) for each in question.what_ifs], "actual_value": question.actual}


def _objects(pictures: Iterable[Iterable[VisibleObject]]) -> list[Row]:
    """Return the objects of pictures, each with the index of its picture."""
    return [_object(place, seen) for place, objects in enumerate(pictures) for seen in objects]


def _object(picture: int, seen: VisibleObject) -> Row:
    numbers = (*seen.position, *seen.orientation, seen.share, seen.across, seen.down, *(seen.color or (None,) * 3))
    known = {"picture": picture, "name": seen.name, "look": " ".join(seen.words), "asked": seen.queried}
    return known | dict(zip(OBJECT_SCALARS, numbers, strict=True))


def _change(change: Change | None) -> str | None:
    if change is None:
        return None
    if change.kind in ("without", "order", "add"):
        return f"{change.kind} {change.target}"
    text = f"{change.kind} {change.target}: {change.before} -> {change.after}"
    return f"{text}; {_change(change.beside)}" if change.beside else text


def _measure(measured: Legibility) -> Row:
    return {"name": measured.name, "unit": measured.unit, "value": measured.value, "bound": measured.bound}


def _strength(strength: Strength | None) -> Row | None:
    if strength is None:
        return None
    return {"name": strength.quantity, "unit": strength.unit, "value": strength.value}


def _channel_columns(context: tuple[Picture, ...]) -> Row:
    """Return the columns of the channels other than colour."""
    row: Row = {}
    if any(p.depth is not None for p in context):
        row["context_depth"] = [_channel(millimetres(p.depth)) for p in context if p.depth is not None]
    if any(p.ids is not None for p in context):
        row["context_ids"] = [_channel((p.ids + 1).astype(np.uint16)) for p in context if p.ids is not None]
        row["context_names"] = list(next(p.names for p in context if p.ids is not None))
    return row


def millimetres(depth: NDArray[np.float32]) -> NDArray[np.uint16]:
    """Return depth (h, w) in metres as whole millimetres, clipped to 16 bits (65 m)."""
    return np.asarray(np.clip(np.rint(depth * 1000.0), 0, 65535).astype(np.uint16))


def encode_picture(pixels: NDArray[np.uint8]) -> dict[str, bytes | None]:
    """Return a picture (h, w, 3) in the layout of a row."""
    return {"bytes": encode_webp(pixels), "path": None}


def _channel(pixels: NDArray[np.uint16]) -> dict[str, bytes | None]:
    return {"bytes": encode_png(pixels), "path": None}


def table(rows: list[Row], columns: pa.Schema) -> pa.Table:
    """Return rows as a table. Raises ValueError if the columns of a row differ from the schema."""
    for row in rows:
        if row.keys() != set(columns.names):
            raise ValueError(f"{row.get('id')} has other columns: {sorted(row.keys() ^ set(columns.names))}")
    return pa.Table.from_pylist(rows, schema=columns)
