"""A task's questions as the audit looks at them: the rows without their pictures' bytes, and small pictures of some."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from wmspec.dataset.build.pictures import opened
from wmspec.dataset.build.reader import PICTURES, DatasetReader
from wmspec.dataset.build.rows import Row

#: Pictures are looked at with so many pixels a side.
SIDE = 48

Small = NDArray[np.uint8]


@dataclass(frozen=True)
class Case:
    """A row: its values, the hashes of its pictures and, if it is looked at, small copies (SIDE, SIDE, 3) of them."""

    row: Row
    context: tuple[bytes, ...]
    options: tuple[bytes, ...]
    seen_context: tuple[Small, ...] = ()
    seen_options: tuple[Small, ...] = ()

    @property
    def pictured(self) -> bool:
        """Whether its options are pictures."""
        return bool(self.options)

    @property
    def open(self) -> bool:
        """Whether it has no options: the answer is said freely."""
        return not self.row["option_kind"]

    @property
    def count(self) -> int:
        """How many options it has."""
        return len(self.row["option_kind"])

    @property
    def moments(self) -> int:
        """At how many different times its pictures were taken."""
        return len(set(self.row["context_time"]))

    def varied(self, sort: str) -> dict[str, Any]:
        """The values of its factors (`sort` factor) or nuisances, by name."""
        return {k.split(".", 1)[1]: v for k, v in self.row.items() if k.startswith(f"{sort}.")}


@dataclass(frozen=True)
class Unit:
    """All rows of one question of a task. `name` is the task's, with the question's number if it has several."""

    name: str
    cases: tuple[Case, ...]
    engines: tuple[str, ...]

    @property
    def open(self) -> bool:
        """Whether its questions have no options."""
        return self.cases[0].open

    @cached_property
    def once(self) -> tuple[Case, ...]:
        """One row for each instance: of the first engine that asks it."""
        first: dict[int, Case] = {}
        for case in self.cases:
            first.setdefault(case.row["index"], case)
        return tuple(first.values())

    @cached_property
    def draws(self) -> int:
        """How many independent control groups its questions come from."""
        return len({case.row["block"] for case in self.cases})

    @cached_property
    def looked_at(self) -> tuple[Case, ...]:
        """The rows whose pictures are looked at, one for each instance, the engines in turn."""
        last = {c.row["index"]: c for c in self.cases if c.seen_context or c.seen_options}
        return tuple(case for _, case in sorted(last.items()))

    @cached_property
    def first_engine(self) -> tuple[Case, ...]:
        """The rows of the first engine whose pictures are looked at."""
        return tuple(c for c in self.cases if c.row["engine"] == self.engines[0] and (c.seen_context or c.seen_options))


@dataclass(frozen=True)
class Enlarging:
    """The pictures of a task at their own size, read once more."""

    dataset: DatasetReader
    task: str

    def __call__(self, indices: set[int]) -> dict[str, list[Small]]:
        """What is shown in the rows of some instances, by their names."""
        rows = self.dataset.rows(self.task, only=indices)
        return {row["id"]: [np.asarray(opened(p["bytes"])) for p in row["context"]] for row in rows}


def units(dataset: DatasetReader, task: str, most: int) -> Iterator[Unit]:
    """The questions of a task. Pictures of at most `most` instances are looked at, the same ones every time."""
    indices = {row["index"] for row in dataset.rows(task, ["index"])}
    chosen = set(sorted(indices, key=lambda i: _key(task, i))[:most])
    parted: dict[int, list[Case]] = {}
    for row in dataset.rows(task):
        looked = row["index"] in chosen and _looked(row, dataset.engines)
        parted.setdefault(row["question"], []).append(_case(row, looked))
    for question, cases in sorted(parted.items()):
        yield Unit(task if len(parted) == 1 else f"{task} q{question}", tuple(cases), dataset.engines)


def task_of(name: str) -> str:
    """The task that a unit of this name is of."""
    return name.partition(" q")[0]


def _looked(row: Row, engines: tuple[str, ...]) -> bool:
    """Every instance is looked at in the first engine, for comparing instances, and in one other, for the probes."""
    return row["engine"] in (engines[0], engines[_turn(row["index"], len(engines))])


def _turn(index: int, count: int) -> int:
    return int.from_bytes(_key("turn", index)[:4], "big") % count


def _key(*parts: object) -> bytes:
    return hashlib.sha256("/".join(map(str, parts)).encode()).digest()


def _case(row: Row, looked: bool) -> Case:
    context, options = ([p["bytes"] for p in row.pop(column)] for column in PICTURES)
    return Case(
        row,
        tuple(hashlib.sha256(b).digest() for b in context),
        tuple(hashlib.sha256(b).digest() for b in options),
        tuple(map(_small, context)) if looked else (),
        tuple(map(_small, options)) if looked else (),
    )


def _small(content: bytes) -> Small:
    return np.asarray(opened(content).resize((SIDE, SIDE), Image.Resampling.BOX))
