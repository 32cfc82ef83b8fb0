"""Entries of a table as rows of a dataset: the columns of all datasets, then factors and their control groups."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence

import pyarrow as pa

from wmspec.dataset.build.rows import COLUMNS, Row, encoded, identity, table_schema
from wmspec.eval.image_import.pictures import Pictures
from wmspec.eval.image_import.table import Entry

#: Who executed and drew: nobody. It is the name of the only "engine" of such a dataset, and its pictures' camera.
CAMERA = "camera"


def rows(entries: Sequence[Entry], pictures: Pictures) -> list[Row]:
    """The rows of a task's entries, in their order.

    Entries of one episode are questions of one instance; those of one group are of one block, others each of their own.
    """
    factors = _factors(entries)
    instances: dict[str, int] = {}
    blocks: dict[str, int] = {}
    asked: dict[int, int] = {}
    made = []
    for entry in entries:
        index = instances.setdefault(entry.episode or f"line {entry.line}", len(instances))
        block = blocks.setdefault(entry.group or f"instance {index}", len(blocks))
        question = asked.get(index, 0)
        asked[index] = question + 1
        made.append(_row(entry, (index, block, question), factors, pictures))
    return made


def schema(entries: Sequence[Entry]) -> pa.Schema:
    """The columns of a task's rows."""
    names = _factors(entries)
    fields = [pa.field(f"factor.{n}", _kind(entries, n), metadata={"unit": ""}) for n in names]
    return table_schema([*fields, *(pa.field(f"group.{n}", pa.string()) for n in names)])


def _factors(entries: Sequence[Entry]) -> list[str]:
    """The factors that a task's rows say anything of."""
    return [n for n in entries[0].factors if any(e.factors[n] for e in entries)]


def _kind(entries: Sequence[Entry], name: str) -> pa.DataType:
    return pa.float64() if all(map(_is_number, (e.factors[name] for e in entries))) else pa.string()


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True


def _row(entry: Entry, place: tuple[int, int, int], factors: list[str], pictures: Pictures) -> Row:
    index, block, question = place
    shown, times = _shown(entry, pictures)
    difference = {"name": entry.quantity, "unit": entry.unit, "value": entry.difference}
    is_open = not entry.options
    levels = {n: float(v) if _is_number(v) else v for n, v in entry.factors.items()}
    return {
        **dict.fromkeys(COLUMNS),
        "id": identity(entry.task, index, question, CAMERA),
        "task": entry.task,
        "dimension": entry.dimension,
        "index": index,
        "block": block,
        "question": question,
        "question_name": entry.name,
        "engine": CAMERA,
        "renderer": CAMERA,
        "text": entry.text,
        "context": shown,
        "context_camera": [CAMERA] * len(shown),
        "context_time": times,
        "option_text": None if entry.pictured else list(entry.options),
        "option_image": [encoded(pictures.still(n)) for n in entry.options] if entry.pictured else [],
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


def _shown(entry: Entry, pictures: Pictures) -> tuple[list[dict[str, bytes | None]], list[float]]:
    if entry.clip:
        pixels, times = pictures.frames(entry.pictures[0], entry.frames)
        return [encoded(p) for p in pixels], times
    return [encoded(pictures.still(name)) for name in entry.pictures], list(entry.times)


def _group(entry: Entry, factor: str, factors: list[str]) -> str:
    """What all rows share that differ in a factor alone."""
    others = [entry.task, entry.group, entry.name, factor, *(f"{n}={entry.factors[n]}" for n in factors if n != factor)]
    return hashlib.sha256("\n".join(others).encode()).hexdigest()[:16]
