"""The audit's view of questions: rows without picture bytes, with thumbnails of a sample."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from wmspec.dataset.build.images import decode_image
from wmspec.dataset.build.reader import PICTURES, DatasetReader
from wmspec.dataset.build.rows import Row

#: Side of a thumbnail (px).
THUMBNAIL_SIZE = 48

Thumbnail = NDArray[np.uint8]


@dataclass(frozen=True)
class Case:
    """A row: its values, the hashes and sizes (bytes) of its pictures and, if sampled, thumbnails (SIDE, SIDE, 3)."""

    row: Row
    context: tuple[bytes, ...]
    options: tuple[bytes, ...]
    context_thumbnails: tuple[Thumbnail, ...] = ()
    option_thumbnails: tuple[Thumbnail, ...] = ()
    context_sizes: tuple[int, ...] = ()
    option_sizes: tuple[int, ...] = ()

    @property
    def has_picture_options(self) -> bool:
        """Whether the options are pictures."""
        return bool(self.options)

    @property
    def open(self) -> bool:
        """Whether the question is open, without options."""
        return not self.row["option_kind"]

    @property
    def required_moments(self) -> int:
        """The number of moments that show the answer: one for what holds from the start."""
        return 1 if self.row["answer_standing"] else self.row.get("answer_moments") or 2

    def requiring(self, moments: int) -> Case:
        """Return the case with another number of required moments."""
        return replace(self, row={**self.row, "answer_standing": moments == 1, "answer_moments": moments})

    @property
    def count(self) -> int:
        """The number of options."""
        return len(self.row["option_kind"])

    @property
    def moments(self) -> int:
        """The number of distinct times of its pictures."""
        return len(set(self.row["context_time"]))

    def varied(self, sort: str) -> dict[str, Any]:
        """Return the values of its factors (`sort` factor) or nuisances, by name."""
        return {k.split(".", 1)[1]: v for k, v in self.row.items() if k.startswith(f"{sort}.")}


@dataclass(frozen=True)
class Unit:
    """All rows of one question of a task. `name` is the task's, with the question's number if it has several.

    `first_engines` are those of which one row an instance is read: the first, or all if a row stands for all engines.
    """

    name: str
    cases: tuple[Case, ...]
    first_engines: tuple[str, ...]

    @property
    def open(self) -> bool:
        """Whether the questions are open, without options."""
        return self.cases[0].open

    @cached_property
    def per_instance(self) -> tuple[Case, ...]:
        """One row for each instance, from the first engine that has it."""
        first: dict[int, Case] = {}
        for case in self.cases:
            first.setdefault(case.row["index"], case)
        return tuple(first.values())

    @cached_property
    def draws(self) -> int:
        """The number of independent control groups."""
        return len({case.row["block"] for case in self.cases})

    @cached_property
    def sampled(self) -> tuple[Case, ...]:
        """The rows with thumbnails, one for each instance, with engines in turn."""
        last = {c.row["index"]: c for c in self.cases if c.context_thumbnails or c.option_thumbnails}
        return tuple(case for _, case in sorted(last.items()))

    @cached_property
    def first_engine(self) -> tuple[Case, ...]:
        """The rows with thumbnails, of the first engine if each engine has its own."""
        return tuple(
            c
            for c in self.cases
            if c.row["engine"] in self.first_engines and (c.context_thumbnails or c.option_thumbnails)
        )


def full_size_pictures(dataset: DatasetReader, task: str, indices: set[int]) -> dict[str, list[Thumbnail]]:
    """Return the pictures shown in the rows of the given instances of a task, at full size, by row id."""
    rows = dataset.rows(task, only=indices)
    return {row["id"]: [np.asarray(decode_image(p["bytes"])) for p in row["context"]] for row in rows}


def units(dataset: DatasetReader, task: str, most: int) -> Iterator[Unit]:
    """Yield the questions of a task. At most `most` instances get thumbnails, always the same ones."""
    indices = {row["index"] for row in dataset.rows(task, ["index"])}
    chosen = set(sorted(indices, key=lambda i: _key(task, i))[:most])
    parted: dict[int, list[Case]] = {}
    for row in dataset.rows(task):
        looked = row["index"] in chosen and (dataset.rows_of == "questions" or _is_sampled(row, dataset.engines))
        parted.setdefault(row["question"], []).append(_case(row, looked))
    first = dataset.engines if dataset.rows_of == "questions" else dataset.engines[:1]
    for question, cases in sorted(parted.items()):
        yield Unit(task if len(parted) == 1 else f"{task} q{question}", tuple(cases), first)


def task_of(name: str) -> str:
    """Return the task of a unit name."""
    return name.partition(" q")[0]


def _is_sampled(row: Row, engines: tuple[str, ...]) -> bool:
    """Whether a row gets thumbnails: the first engine, for comparing instances, and one other, for probes."""
    turn = int.from_bytes(_key("turn", row["index"])[:4], "big")
    return row["engine"] in (engines[0], engines[turn % len(engines)])


def _key(*parts: object) -> bytes:
    return hashlib.sha256("/".join(map(str, parts)).encode()).digest()


def _case(row: Row, looked: bool) -> Case:
    context, options = ([p["bytes"] for p in row.pop(column)] for column in PICTURES)
    return Case(
        row,
        tuple(hashlib.sha256(b).digest() for b in context),
        tuple(hashlib.sha256(b).digest() for b in options),
        tuple(map(_thumbnail, context)) if looked else (),
        tuple(map(_thumbnail, options)) if looked else (),
        tuple(map(len, context)),
        tuple(map(len, options)),
    )


def _thumbnail(content: bytes) -> Thumbnail:
    return np.asarray(decode_image(content).resize((THUMBNAIL_SIZE, THUMBNAIL_SIZE), Image.Resampling.BOX))
