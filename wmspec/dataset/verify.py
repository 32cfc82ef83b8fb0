"""Whether a dataset's rows come out again: instances are made anew and held against what the folder has.

With the same engines and graphics every byte is the same. Elsewhere the last digits of a simulation and the pixels at
edges are others: then what counts is that texts, options and answers are the same, and numbers and pictures nearly so.
"""

from __future__ import annotations

import io
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from PIL import Image

from wmspec.dataset.build.generate import job_of
from wmspec.dataset.build.plan import Plan
from wmspec.dataset.build.reader import CHANNELS, PICTURES, DatasetReader
from wmspec.dataset.build.rows import Row, identity
from wmspec.dataset.build.units import units, weight
from wmspec.dataset.build.worker import work
from wmspec.runtime.workers.pool import Effort, Lost, by_units

#: Numbers are near if they differ by less than this share, or by less than this (SI units).
NEAR, NEAR_ZERO = 0.01, 1e-3
#: Pictures are near if their pixels (0 to 255) differ by less than this on average.
NEAR_PIXELS = 2.0

Verdict = Literal["same", "near", "different"]


@dataclass(frozen=True)
class Difference:
    """The first thing in which a question came out otherwise: its id, the column (empty: the whole row), in words."""

    id: str
    column: str
    words: str
    near: bool

    def __str__(self) -> str:
        return f"{self.id}: {self.column}: {self.words}" if self.column else f"{self.id}: {self.words}"


@dataclass(frozen=True)
class Verification:
    """How many questions were made anew, and those that came out otherwise, the first difference of each.

    `versions` are what is installed here in other versions than the dataset was made with: there, and here.
    """

    questions: int
    differences: tuple[Difference, ...]
    versions: Mapping[str, tuple[str, str]]

    @property
    def verdict(self) -> Verdict:
        """The worst of all."""
        if not self.differences:
            return "same"
        return "near" if all(difference.near for difference in self.differences) else "different"


def verify(dataset: DatasetReader, plan: Plan, effort: Effort, progress: Callable[[str, int], None]) -> Verification:
    """Make the instances of the plan anew. Its tasks are some of the dataset's, with some of its instances."""
    job, differences, questions = job_of(plan, effort), list[Difference](), 0
    tasks = {task.spec.name: task for task in plan.tasks}
    every = (
        [(own, name, piece) for piece in unit]
        for name, task in tasks.items()
        for own in [job.of(name)]
        for unit in units(task.spec, plan.seed, task.indices)
    )
    with closing(by_units(work, every, effort, lambda p: weight(tasks[p[1]].spec, p[2]))) as outcomes:
        for (_, name, indices), made in outcomes:
            there = _there(dataset, name, indices)
            for at, index in enumerate(indices):
                here = made if isinstance(made, Lost) else {row["id"]: row for row in made.outcomes[at].rows}
                rejected = (
                    {}
                    if isinstance(made, Lost)
                    else {
                        identity(r.task, r.index, r.question, r.engine): f"{r.reason}: {r.detail}"
                        for r in made.outcomes[at].rejected
                    }
                )
                for engine in plan.engines:
                    for q in range(len(tasks[name].spec.questions)):
                        id_ = identity(name, index, q, engine)
                        differences += _compared(id_, there.get(id_), here, rejected)
                        questions += 1
                progress(name, 1)
    there_versions = dataset.manifest["versions"]
    versions = {n: (there_versions.get(n, "none"), v) for n, v in plan.versions.items() if there_versions.get(n) != v}
    return Verification(questions, tuple(sorted(differences, key=lambda d: d.id)), versions)


def _there(dataset: DatasetReader, task: str, indices: Sequence[int]) -> dict[str, Row]:
    columns = dataset.columns(task)
    return {row["id"]: row for row in dataset.rows(task, columns, set(indices))} if columns else {}


def _compared(
    id_: str, there: Row | None, here: Mapping[str, Row] | Lost, rejected: Mapping[str, str]
) -> Iterator[Difference]:
    """The first difference of a question, if there is one."""
    if isinstance(here, Lost):
        yield Difference(id_, "", f"it cannot be made here: {here.reason}", False)
    elif there is None and id_ in here:
        yield Difference(id_, "", "it was rejected, and is asked here", False)
    elif there is not None and id_ not in here:
        yield Difference(id_, "", f"it is asked in the dataset, and rejected here ({rejected.get(id_, '')})", False)
    elif there is not None:
        differences = [d for name in there for d in _column(id_, name, there[name], here[id_].get(name))]
        yield from sorted(differences, key=lambda d: d.near)[:1]


def _column(id_: str, name: str, there: Any, here: Any) -> Iterator[Difference]:
    if name in (*PICTURES, *CHANNELS):
        yield from _pictures(id_, name, there or [], here or [])
    elif (words := _apart(there, here)) is not None:
        yield Difference(id_, name, f"{_short(there)} in the dataset, {_short(here)} here{words[0]}", words[1])


def _apart(there: Any, here: Any) -> tuple[str, bool] | None:
    """By how much two values differ, in words, and whether that is little; None if they are the same."""
    if there == here or (isinstance(there, list | tuple) and list(there) == list(here or ())):
        return None
    a, b = _numbers(there), _numbers(here)
    if a is None or b is None or len(a) != len(b) or _words(there) != _words(here):
        return "", False
    gaps = [abs(x - y) for x, y in zip(a, b, strict=True)]
    near = all(math.isclose(x, y, rel_tol=NEAR, abs_tol=NEAR_ZERO) for x, y in zip(a, b, strict=True))
    return f", {max(gaps):.2g} apart", near


def _numbers(value: Any) -> list[float] | None:
    """All floating-point numbers in a value, in order; None if there are none."""
    if isinstance(value, float):
        return [value]
    parts = value.values() if isinstance(value, dict) else value if isinstance(value, list | tuple) else ()
    numbers = [number for part in parts for number in _numbers(part) or ()]
    return numbers or None


def _words(value: Any) -> Any:
    """A value without its floating-point numbers."""
    if isinstance(value, float):
        return None
    if isinstance(value, dict):
        return {name: _words(part) for name, part in value.items()}
    return [_words(part) for part in value] if isinstance(value, list | tuple) else value


def _short(value: Any) -> str:
    text = str(value)
    return text if len(text) <= 60 else f"{text[:57]}..."


def _pictures(id_: str, name: str, there: Sequence[Any], here: Sequence[Any]) -> Iterator[Difference]:
    """The pictures of a column that are not the same file."""
    if len(there) != len(here):
        yield Difference(id_, name, f"{len(there)} pictures in the dataset, {len(here)} here", False)
        return
    for number, (a, b) in enumerate(zip(there, here, strict=True), 1):
        if a["bytes"] == b["bytes"]:
            continue
        x, y = (np.asarray(Image.open(io.BytesIO(one["bytes"])), np.float64) for one in (a, b))
        if x.shape != y.shape:
            yield Difference(id_, name, f"picture {number} is {x.shape} in the dataset, {y.shape} here", False)
            continue
        apart = np.abs(x - y)
        words = f"picture {number} differs in {(apart > 0).mean():.2%} of its values, by {apart.mean():.2g} on average"
        yield Difference(id_, name, words, bool(apart.mean() < NEAR_PIXELS))
