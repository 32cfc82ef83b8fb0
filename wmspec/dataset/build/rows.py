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
from wmspec.compile.design.what_ifs import imagines
from wmspec.dataset.build.identity import identity
from wmspec.dataset.build.images import encode_png, encode_webp
from wmspec.lang.check.ir.ir import Choices, Factor, TaskSpec
from wmspec.runtime.questions.consensus import RowsOf
from wmspec.runtime.questions.kinds import KINDS
from wmspec.runtime.questions.model import Change, Picture, QuestionRow, Strength, VisibleObject, Vote
from wmspec.runtime.questions.views import channels_of

Row = dict[str, Any]

_IMAGES = pa.list_(pa.struct([("bytes", pa.binary()), ("path", pa.string())]))
_TEXTS = pa.list_(pa.string())
_READINGS = pa.list_(pa.struct([("name", pa.string()), ("value", pa.float64())]))
_VOTE = [("engine", pa.string()), ("answer", pa.int64()), ("value", pa.string()), ("rejected", pa.string())]
_EARLIER_VOTES = pa.list_(pa.struct(_VOTE))
_VOTES = pa.list_(pa.struct([*_VOTE, ("apart", pa.float64())]))
_STRENGTH = pa.struct([("name", pa.string()), ("unit", pa.string()), ("value", pa.float64())])
_LEGIBILITY = pa.list_(
    pa.struct([("name", pa.string()), ("unit", pa.string()), ("value", pa.float64()), ("bound", pa.float64())])
)
_SCALARS = ("x", "y", "z", "qw", "qx", "qy", "qz", "share", "across", "down", "red", "green", "blue")
_OBJECTS = pa.list_(
    pa.struct(
        [("picture", pa.int64()), ("name", pa.string()), ("look", pa.string()), ("asked", pa.bool_())]
        + [(name, pa.float64()) for name in _SCALARS]
    )
)

#: The columns that every task has: type and description.
COLUMNS: dict[str, tuple[pa.DataType, str]] = {
    "id": (
        pa.string(),
        "the task, and a hash of seed, instance and question, and of the engine if there is one row for each",
    ),
    "task": (pa.string(), "the task"),
    "dimension": (pa.string(), "what is tested, from broad to narrow"),
    "index": (pa.int64(), "which instance of the task's design"),
    "block": (pa.int64(), "which repetition of the design; instances of a block share their nuisances"),
    "crossed": (_TEXTS, "the factors that vary within the block"),
    "question": (pa.int64(), "which of the task's questions"),
    "question_name": (pa.string(), "the question's name; empty if it has none"),
    "engine": (
        pa.string(),
        (
            "the reference engine, which executed the episode that is shown: the first of the engines, for which "
            "`all` lists MuJoCo first, because it is the quickest; the others confirm its answer (`agreement`)"
        ),
    ),
    "renderer": (pa.string(), "the engine that drew the pictures"),
    "text": (pa.string(), "the question"),
    "context": (_IMAGES, "the pictures shown with the question"),
    "context_camera": (_TEXTS, "the camera of each picture shown"),
    "context_time": (pa.list_(pa.float64()), "the time (s) of each picture shown"),
    "context_objects": (
        _OBJECTS,
        (
            "of each picture shown (from 0): the objects that can move or are asked about, by name, the words for "
            "their looks, their middles (m) and turns (a quaternion), the share of the picture that shows them, where "
            "(0 to 1, from the left and from the top) and in what mean colour (sRGB, 0 to 1)"
        ),
    ),
    "option_text": (_TEXTS, "the options, if they are words; null if they are pictures, empty for an open question"),
    "option_image": (_IMAGES, "the options, if they are pictures; empty if they are words"),
    "option_kind": (_TEXTS, "what each option is: truth, label, counterfactual; of a closed set state, action, both"),
    "option_name": (_TEXTS, "the name of each option: of the label's value or of the counterfactual"),
    "option_change": (_TEXTS, "what each counterfactual changed: its kind, what, from what, to what"),
    "option_objects": (_OBJECTS, "the same of each option that is a picture"),
    "answer": (pa.int64(), "the place (from 0) of the true option; null for an open question"),
    "answer_value": (pa.string(), "the answer, measured on the executed episode, in words"),
    "answer_number": (pa.float64(), "the answer, if it is a number"),
    "answer_unit": (pa.string(), "the SI unit of that number; empty for plain numbers"),
    "answer_within": (pa.float64(), "for an open question: how far off a number is still right"),
    "answer_standing": (pa.bool_(), "whether the answer holds from the start, whatever happens"),
    "answer_moments": (
        pa.int64(),
        "how many moments it takes to see the answer: 1 if any shows it, 2 for a change, 3 for its course",
    ),
    "difference": (_STRENGTH, "how strong the stimulus is: the quantity, its SI unit, its value"),
    "margin": (pa.float64(), "how far the answer is from turning, in multiples of the required margin"),
    "legibility": (
        _LEGIBILITY,
        "how clearly the pictures show what decides the answer: each measure, its unit, its value, and its bound",
    ),
    "measured": (_READINGS, "quantities measured, in SI units"),
    "agreement": (
        _VOTES,
        (
            "of each engine: the option that its outcome picks, its answer, or why it rejects, and the largest "
            "distance (m) of a body from its place in the engine of the row, at the same time"
        ),
    ),
    "seed": (pa.int64(), "the seed of the design"),
}

#: The types that columns had in earlier formats.
EARLIER_TYPES: dict[str, tuple[pa.DataType, ...]] = {"agreement": (_EARLIER_VOTES,)}

#: Additional columns for questions with named outcomes.
OUTCOMES: dict[str, tuple[pa.DataType, str]] = {
    "option_outcome": (_TEXTS, "of what kind each option is as an outcome; null where the question names none")
}

#: Additional columns for questions about what would have been.
WHAT_IFS: dict[str, tuple[pa.DataType, str]] = {
    "what_if": (_TEXTS, "the changes that the question imagines: the kind of each, what, from what, to what"),
    "actual_value": (pa.string(), "what the answer would be in the episode as it is, in words; null if it has none"),
}

#: Additional columns for questions with balanced answers.
REDRAWN: dict[str, tuple[pa.DataType, str]] = {
    "redrawn": (pa.int64(), "how often the nuisances of the block were drawn before these, for the balance of answers")
}

#: Additional columns for questions with objects that may be hidden.
HIDDEN: dict[str, tuple[pa.DataType, str]] = {
    "context_visible": (
        pa.list_(pa.struct([("picture", pa.int64()), ("name", pa.string()), ("share", pa.float64())])),
        (
            "of each picture shown (from 0), for every object that the question allows to be hidden: the share of it "
            "that is visible, 0 if it is behind something, outside the picture, or has vanished"
        ),
    )
}

_TRACK = pa.list_(
    pa.struct(
        [("name", pa.string()), ("frame", pa.int64())]
        + [(name, pa.float64()) for name in ("x", "y", "z", "across", "down", "share")]
    )
)

#: Additional columns of datasets with films; null or empty for questions without a closed set of films.
FILMS: dict[str, tuple[pa.DataType, str]] = {
    "film": (pa.string(), "the path of the film: the context, and then what happens"),
    "film_rate": (pa.int64(), "its frames per second"),
    "film_start": (pa.float64(), "the time (s) of its first frame"),
    "film_context": (pa.int64(), "how many of its frames are shown"),
    "film_answer": (pa.int64(), "which frame (from 0) is nearest to the time of the answer"),
    "film_offset": (pa.float64(), "how much later (s) that frame is than the answer"),
    "film_moving": (pa.int64(), "in how many frames of the context something moves"),
    "film_text": (pa.string(), "the scene in words, for video models"),
    "action_text": (pa.string(), "the action in words, for models that receive the last picture of the context only"),
    "film_bodies": (_TEXTS, "the names of all bodies; the films of ids have their places here, plus 1"),
    "film_objects": (_TEXTS, "the objects whose places tell the films of the options apart"),
    "film_engines": (_TEXTS, "the other engines that have films of the futures, in half the size"),
    "option_film": (_TEXTS, "the path of the film of each option"),
    "film_apart": (
        pa.list_(pa.float64()),
        (
            "how far the futures of each two options are apart, row by row (object widths: the mean of that over the "
            "whole way and that of the last three frames)"
        ),
    ),
    "film_track": (
        _TRACK,
        "where each of the objects is in each frame: its middle (m), and its place and share in the picture (0 to 1)",
    ),
}
#: The film columns of a row without a film.
NO_FILM: Row = {name: [] if pa.types.is_list(kind) else None for name, (kind, _) in FILMS.items()}

#: Additional columns for picture channels other than colour.
CHANNELS: dict[str, dict[str, tuple[pa.DataType, str]]] = {
    "depth": {
        "context_depth": (_IMAGES, "of each picture shown: distance along the view axis in mm, 16 bits, 0 for none")
    },
    "ids": {
        "context_ids": (
            _IMAGES,
            "of each picture shown: the place (from 1) in `context_names` of what is seen, 16 bits",
        ),
        "context_names": (_TEXTS, "the names of all objects"),
    },
}

#: `"Sequence"`, because versions of `datasets` before 4 do not know `"List"`, and later ones read both.
_FEATURE = {"_type": "Sequence", "feature": {"_type": "Image"}}


def schema(spec: TaskSpec, films: bool = False) -> pa.Schema:
    """Return the columns of a task: common ones, balance, outcomes, channels, films, then `factor.*`, `level.*`,
    `group.*`, `nuisance.*`.

    A factor's column is boolean, float64, string, or a list of float64 for points; its metadata hold the SI `unit` and
    the dimension that it is `about`.
    `group.f` is the key shared by all instances that differ in `f` alone, so one `groupby` gives the groups. `level.f`
    is the name of a value of a factor or nuisance with named values.
    """
    varied, drawn = _split_nuisances(spec.factors)
    fields = [
        pa.field(name, kind)
        for columns in (
            redraw_columns(spec),
            outcome_columns(spec),
            hidden_columns(spec),
            what_if_columns(spec),
            channel_columns(spec),
            FILMS if films else {},
        )
        for name, (kind, _) in columns.items()
    ]
    fields += [_column(spec, "factor", f) for f in varied]
    fields += [pa.field(f"level.{f.name}", pa.string()) for f in (*varied, *drawn) if _has_named_values(f)]
    fields += [pa.field(f"group.{f.name}", pa.string()) for f in varied]
    fields += [_column(spec, "nuisance", f) for f in drawn]
    return table_schema(fields)


def table_schema(more: Iterable[pa.Field]) -> pa.Schema:
    """Return the columns that every dataset has and the given ones, with the metadata of Hugging Face `datasets`."""
    fields = [*(pa.field(name, kind) for name, (kind, _) in COLUMNS.items()), *more]
    features = {f.name: _FEATURE for f in fields if f.type == _IMAGES}
    return pa.schema(fields, metadata={"huggingface": json.dumps({"info": {"features": features}})})


def redraw_columns(spec: TaskSpec) -> dict[str, tuple[pa.DataType, str]]:
    """Return the columns for balanced answers, if a question has them."""
    return REDRAWN if spec.plan.balance else {}


def outcome_columns(spec: TaskSpec) -> dict[str, tuple[pa.DataType, str]]:
    """Return the columns for outcomes, if a question names some."""
    return OUTCOMES if any(question.kinds for question in spec.questions) else {}


def hidden_columns(spec: TaskSpec) -> dict[str, tuple[pa.DataType, str]]:
    """Return the columns for objects that may be hidden, if a question has some."""
    return HIDDEN if any(question.visibility for question in spec.questions) else {}


def what_if_columns(spec: TaskSpec) -> dict[str, tuple[pa.DataType, str]]:
    """Return the columns for what-ifs, if a question has some."""
    return WHAT_IFS if any(imagines(question) for question in spec.questions) else {}


def _has_named_values(factor: Factor) -> bool:
    """Whether a factor has named values."""
    return isinstance(factor.domain, Choices) and factor.domain.names is not None


def channel_columns(spec: TaskSpec) -> dict[str, tuple[pa.DataType, str]]:
    """Return the columns of a task's picture channels other than colour."""
    keys = channels_of(spec)
    return {name: column for channel in CHANNELS if channel in keys for name, column in CHANNELS[channel].items()}


def _split_nuisances(factors: Iterable[Factor]) -> tuple[list[Factor], list[Factor]]:
    """Return factors and nuisances separately."""
    everything = list(factors)
    return [f for f in everything if not f.nuisance], [f for f in everything if f.nuisance]


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
        "context": [_image(p) for p in question.context],
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
        "legibility": [asdict(each) for each in question.legibility],
        "measured": [{"name": n, "value": float(v)} for n, v in question.measured.items()],
        "agreement": [_vote(v) for v in question.agreement],
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
    options, offered = question.options, KINDS[question.kind].option_set(question.options)
    if len(offered.texts or ()) + len(offered.pictures) != len(options):
        raise ValueError("every option of a question has a text, or every one has a picture")
    return {
        "option_text": None if offered.texts is None else list(offered.texts),
        "option_image": [_image(p) for p in offered.pictures],
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
    return known | dict(zip(_SCALARS, numbers, strict=True))


def _change(change: Change | None) -> str | None:
    if change is None:
        return None
    if change.kind in ("without", "order", "add"):
        return f"{change.kind} {change.target}"
    text = f"{change.kind} {change.target}: {change.before} -> {change.after}"
    return f"{text}; {_change(change.beside)}" if change.beside else text


def _vote(vote: Vote) -> Row:
    return asdict(vote)


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


def _image(picture: Picture) -> dict[str, bytes | None]:
    return encode_picture(picture.rgb)


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
