"""Table entries as dataset rows: the common columns, then factors and their control groups."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence

import pyarrow as pa

from wmspec.dataset.build.columns import COLUMNS
from wmspec.dataset.build.identity import identity
from wmspec.dataset.build.rows import Row, encode_picture, table_schema
from wmspec.eval.image_import.decode import PictureFolder
from wmspec.eval.image_import.table import Entry
from wmspec.eval.image_import.wm_abench import Pictures

#: A source of pictures by name.
PictureSource = PictureFolder | Pictures
#: The name of the only engine and camera of an imported dataset.
CAMERA_ENGINE = "camera"


def rows(entries: Sequence[Entry], pictures: PictureSource, first: int = 0) -> list[Row]:
    """Return the rows of a task's entries, in order, with instances and blocks numbered from `first`.

    Entries of one episode are questions of one instance. Entries of one group are in one block; others have a block
    each.
    """
    factors = _factors(entries)
    instances: dict[str, int] = {}
    blocks: dict[str, int] = {}
    question_counts: dict[int, int] = {}
    made = []
    for entry in entries:
        index = instances.setdefault(entry.episode or f"line {entry.line}", first + len(instances))
        block = blocks.setdefault(entry.group or f"instance {index}", first + len(blocks))
        question = question_counts.get(index, 0)
        question_counts[index] = question + 1
        made.append(_row(entry, (index, block, question), factors, pictures))
    return made


def schema(entries: Sequence[Entry]) -> pa.Schema:
    """Return the columns of a task's rows."""
    names = _factors(entries)
    fields = [pa.field(f"factor.{n}", _kind(entries, n), metadata={"unit": ""}) for n in names]
    return table_schema([*fields, *(pa.field(f"group.{n}", pa.string()) for n in names)])


def _factors(entries: Sequence[Entry]) -> list[str]:
    """Return the factors that a task's rows use."""
    return [n for n in entries[0].factors if any(e.factors[n] for e in entries)]


def _kind(entries: Sequence[Entry], name: str) -> pa.DataType:
    return pa.float64() if all(map(_is_number, (e.factors[name] for e in entries))) else pa.string()


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True


def _row(entry: Entry, place: tuple[int, int, int], factors: list[str], pictures: PictureSource) -> Row:
    index, block, question = place
    shown, times = _context_pictures(entry, pictures)
    difference = {"name": entry.quantity, "unit": entry.unit, "value": entry.difference}
    is_open = not entry.options
    levels = {n: float(v) if _is_number(v) else v for n, v in entry.factors.items()}
    return {
        **dict.fromkeys(COLUMNS),
        "id": identity(0, entry.task, index, question, CAMERA_ENGINE),
        "task": entry.task,
        "dimension": entry.dimension,
        "index": index,
        "block": block,
        "question": question,
        "question_name": entry.name,
        "engine": CAMERA_ENGINE,
        "renderer": CAMERA_ENGINE,
        "text": entry.text,
        "context": shown,
        "context_camera": [CAMERA_ENGINE] * len(shown),
        "context_time": times,
        "option_text": None if entry.pictured else list(entry.options),
        "option_image": [encode_picture(pictures.still(n)) for n in entry.options] if entry.pictured else [],
        "option_kind": ["truth" if i == entry.answer else "label" for i in range(len(entry.options))],
        "option_name": list(entry.options),
        "option_change": [None] * len(entry.options),
        "answer": entry.answer,
        "answer_value": entry.value,
        "answer_number": entry.number,
        "answer_unit": entry.unit if is_open else None,
        "answer_within": entry.within if is_open else None,
        "answer_standing": False,
        "difference": None if entry.difference is None else difference,
        "measured": [],
        "agreement": [],
        "seed": 0,
        **{f"factor.{n}": levels[n] for n in factors},
        **{f"group.{n}": _group(entry, n, factors) for n in factors},
    }


def _context_pictures(entry: Entry, pictures: PictureSource) -> tuple[list[dict[str, bytes | None]], list[float]]:
    if entry.clip:
        pixels, times = pictures.frames(entry.pictures[0], entry.frames)
        return [encode_picture(p) for p in pixels], times
    return [encode_picture(pictures.still(name)) for name in entry.pictures], list(entry.times)


def _group(entry: Entry, factor: str, factors: list[str]) -> str:
    """Return the key of all rows that differ in this factor alone."""
    others = [entry.task, entry.group, entry.name, factor, *(f"{n}={entry.factors[n]}" for n in factors if n != factor)]
    return hashlib.sha256("\n".join(others).encode()).hexdigest()[:16]
