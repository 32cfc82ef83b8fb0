"""The columns of a dataset: name, type and description, in one list for rows, card, metadata and documentation."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import pyarrow as pa

from wmspec.compile.design.what_ifs import imagines
from wmspec.lang.check.ir.ir import TaskSpec
from wmspec.runtime.questions.views import channels_of

#: Type and description of columns by name.
Columns = dict[str, tuple[pa.DataType, str]]

#: The type of columns that hold pictures.
IMAGES = pa.list_(pa.struct([("bytes", pa.binary()), ("path", pa.string())]))
_TEXTS = pa.list_(pa.string())
_READINGS = pa.list_(pa.struct([("name", pa.string()), ("value", pa.float64())]))
_VOTE = [("engine", pa.string()), ("answer", pa.int64()), ("value", pa.string()), ("rejected", pa.string())]
_EARLIER_VOTES = pa.list_(pa.struct(_VOTE))
_VOTES = pa.list_(pa.struct([*_VOTE, ("apart", pa.float64())]))
_STRENGTH = pa.struct([("name", pa.string()), ("unit", pa.string()), ("value", pa.float64())])
_LEGIBILITY = pa.list_(
    pa.struct([("name", pa.string()), ("unit", pa.string()), ("value", pa.float64()), ("bound", pa.float64())])
)
OBJECT_SCALARS = ("x", "y", "z", "qw", "qx", "qy", "qz", "share", "across", "down", "red", "green", "blue")
_OBJECTS = pa.list_(
    pa.struct(
        [("picture", pa.int64()), ("name", pa.string()), ("look", pa.string()), ("asked", pa.bool_())]
        + [(name, pa.float64()) for name in OBJECT_SCALARS]
    )
)

#: The columns that every task has: type and description.
COLUMNS: Columns = {
    "id": (
        pa.string(),
        "the task, and a hash of seed, instance and question; also of the engine, if each engine has a row",
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
            "the reference engine, which executed the episode that is shown: the first one listed (of `all`, MuJoCo, "
            "the quickest); the others confirm its answer (`agreement`)"
        ),
    ),
    "renderer": (pa.string(), "the engine that drew the pictures"),
    "text": (pa.string(), "the question"),
    "context": (IMAGES, "the pictures shown with the question"),
    "context_camera": (_TEXTS, "the camera of each picture shown"),
    "context_time": (pa.list_(pa.float64()), "the time (s) of each picture shown"),
    "context_objects": (
        _OBJECTS,
        (
            "for each picture shown (from 0), the objects that can move or are in the question: name, words for the "
            "look, middle (m), orientation (quaternion), share of the picture, place in it (0 to 1, from the left and "
            "the top), mean colour (sRGB, 0 to 1)"
        ),
    ),
    "option_text": (_TEXTS, "the options, if they are words; null if they are pictures, empty for an open question"),
    "option_image": (IMAGES, "the options, if they are pictures; empty if they are words"),
    "option_kind": (_TEXTS, "kind of each option: truth, label, counterfactual; in a closed set: state, action, both"),
    "option_name": (_TEXTS, "the name of each option: of the label's value or of the counterfactual"),
    "option_change": (_TEXTS, "what each counterfactual changed: its kind, what, from what, to what"),
    "option_objects": (_OBJECTS, "as `context_objects`, for each option that is a picture"),
    "answer": (pa.int64(), "the place (from 0) of the true option; null for an open question"),
    "answer_value": (pa.string(), "the answer, measured on the executed episode, in words"),
    "answer_number": (pa.float64(), "the answer, if it is a number"),
    "answer_unit": (pa.string(), "the SI unit of that number; empty for plain numbers"),
    "answer_within": (pa.float64(), "for an open question: the largest error of a right number"),
    "answer_standing": (pa.bool_(), "whether the answer holds from the start, whatever happens"),
    "answer_moments": (
        pa.int64(),
        "number of moments needed to see the answer: 1 if any shows it, 2 for a change, 3 for the course of a change",
    ),
    "difference": (_STRENGTH, "how strong the stimulus is: the quantity, its SI unit, its value"),
    "margin": (pa.float64(), "distance of the answer from changing, in multiples of the required margin"),
    "legibility": (
        _LEGIBILITY,
        "how clearly the pictures show what decides the answer: each measure, its unit, its value, and its bound",
    ),
    "measured": (_READINGS, "quantities measured, in SI units"),
    "agreement": (
        _VOTES,
        (
            "for each engine: the option that its outcome selects and its answer, or why it rejects the question; and "
            "the largest distance (m) of a body from its place in the reference engine at the same time"
        ),
    ),
    "seed": (pa.int64(), "the seed of the design"),
}

#: The types that columns had in earlier formats.
EARLIER_TYPES: dict[str, tuple[pa.DataType, ...]] = {"agreement": (_EARLIER_VOTES,)}

#: Additional columns for questions with named outcomes.
OUTCOMES: Columns = {"option_outcome": (_TEXTS, "kind of outcome of each option; null where the question names none")}

#: Additional columns for questions about what would have been.
WHAT_IFS: Columns = {
    "what_if": (_TEXTS, "the changes that the question imagines: the kind of each, what, from what, to what"),
    "actual_value": (pa.string(), "what the answer would be in the episode as it is, in words; null if it has none"),
}

#: Additional columns for questions with balanced answers.
REDRAWN: Columns = {
    "redrawn": (pa.int64(), "number of draws of the block's nuisances that were discarded to balance the answers")
}

#: Additional columns for questions with objects that may be hidden.
HIDDEN: Columns = {
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

#: Additional columns of datasets with films; null or empty for questions without a film.
FILMS: Columns = {
    "film": (pa.string(), "the path of the film: the context, and then what happens"),
    "film_camera": (pa.string(), "its camera"),
    "film_rate": (pa.int64(), "its frames per second"),
    "film_start": (pa.float64(), "the time (s) of its first frame"),
    "film_context": (pa.int64(), "number of its frames that are shown as context"),
    "film_answer": (pa.int64(), "which frame (from 0) is nearest to the time of the answer"),
    "film_offset": (pa.float64(), "how much later (s) that frame is than the answer"),
    "film_moving": (pa.int64(), "in how many frames of the context something moves"),
    "film_text": (pa.string(), "the scene in words, for video models"),
    "action_text": (pa.string(), "the action in words, for models that receive the last picture of the context only"),
    "film_bodies": (_TEXTS, "names of all bodies; pixels in films of ids are the place in this list, plus 1"),
    "film_objects": (_TEXTS, "the objects whose places tell the films of the options apart"),
    "film_engines": (_TEXTS, "the other engines that have films of the futures, in half the size"),
    "option_film": (_TEXTS, "the path of the film of each option"),
    "film_split": (pa.int64(), "for `answer possible`: number of frames before the event that may be impossible"),
    "film_apart": (
        pa.list_(pa.float64()),
        (
            "distance of the futures of each two options, as a matrix by rows (object widths; mean of the distance "
            "over the whole film and that in the last three frames)"
        ),
    ),
    "film_track": (
        _TRACK,
        "where each of the objects is in each frame: its middle (m), and its place and share in the picture (0 to 1)",
    ),
}
#: Additional columns for the picture channel `depth`.
DEPTH: Columns = {
    "context_depth": (IMAGES, "of each picture shown: distance along the view axis in mm, 16 bits, 0 for none")
}

#: Additional columns for the picture channel `ids`.
IDS: Columns = {
    "context_ids": (
        IMAGES,
        "for each picture shown: the place (from 1) in `context_names` of the object at each pixel, 16 bits",
    ),
    "context_names": (_TEXTS, "the names of all objects"),
}


@dataclass(frozen=True)
class ColumnGroup:
    """Columns that only some datasets have.

    `applies` returns whether a task has them, given its spec and whether the dataset has films.
    """

    heading: str
    columns: Columns
    applies: Callable[[TaskSpec, bool], bool]


#: The optional columns, in the order of a row.
OPTIONAL = (
    ColumnGroup("Balanced answers", REDRAWN, lambda spec, _: bool(spec.plan.balance)),
    ColumnGroup("Questions with named outcomes", OUTCOMES, lambda spec, _: any(q.kinds for q in spec.questions)),
    ColumnGroup("Objects that may be hidden", HIDDEN, lambda spec, _: any(q.visibility for q in spec.questions)),
    ColumnGroup("What-ifs", WHAT_IFS, lambda spec, _: any(map(imagines, spec.questions))),
    ColumnGroup("Channel `depth`", DEPTH, lambda spec, _: "depth" in channels_of(spec)),
    ColumnGroup("Channel `ids`", IDS, lambda spec, _: "ids" in channels_of(spec)),
    ColumnGroup("Films", FILMS, lambda _, films: films),
)

#: Description of the columns of factors and nuisances, by the prefix of their names.
FACTOR_COLUMNS = {
    "factor": "the value of the factor, in the SI unit that the column's metadata names",
    "level": "the name of the value of a factor or nuisance with named values",
    "group": "a key that instances share if they differ in the factor alone: group by it",
    "nuisance": "the value of the nuisance, in the SI unit that the column's metadata names",
}

_DESCRIPTIONS = {
    name: text for columns in (COLUMNS, *(g.columns for g in OPTIONAL)) for name, (_, text) in columns.items()
}


def optional_columns(spec: TaskSpec, films: bool = False) -> Columns:
    """Return the optional columns of a task, without those of factors, in the order of a row."""
    return {n: column for group in OPTIONAL if group.applies(spec, films) for n, column in group.columns.items()}


def description(column: str) -> str:
    """Return the description of a column. Raises KeyError if it has none."""
    prefix, dot, _ = column.partition(".")
    return FACTOR_COLUMNS[prefix] if dot else _DESCRIPTIONS[column]
