"""Verification: generates instances again and compares them with the rows of a dataset.

With the same engines and graphics driver all bytes are equal. On another machine the last digits of a simulation and
pixels at edges may differ. Then texts, options and answers must be equal, numbers and pictures nearly equal.
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

from wmspec.dataset.build.batching import batches, weight
from wmspec.dataset.build.generate import job_of
from wmspec.dataset.build.identity import identity
from wmspec.dataset.build.plan import Plan
from wmspec.dataset.build.reader import CHANNELS, PICTURES, DatasetReader
from wmspec.dataset.build.rows import Row
from wmspec.dataset.build.worker import make_instances
from wmspec.runtime.workers.pool import JobFailure, PoolConfig, map_batches

#: Relative and absolute (SI units) tolerance within which numbers are nearly equal.
NEAR_RELATIVE, NEAR_ABSOLUTE = 0.01, 1e-3
#: Mean absolute difference of pixel values (0 to 255) below which pictures are nearly equal.
NEAR_PIXELS = 2.0

Verdict = Literal["same", "near", "different"]


@dataclass(frozen=True)
class Difference:
    """The first difference of a question: its id, the column (empty for the whole row), a description."""

    id: str
    column: str
    words: str
    near: bool

    def __str__(self) -> str:
        return f"{self.id}: {self.column}: {self.words}" if self.column else f"{self.id}: {self.words}"


@dataclass(frozen=True)
class Verification:
    """The number of questions generated again, and the first difference of each that differs.

    `versions` maps packages whose installed version differs to (version in the dataset, version installed).
    """

    questions: int
    differences: tuple[Difference, ...]
    versions: Mapping[str, tuple[str, str]]

    @property
    def verdict(self) -> Verdict:
        """The worst verdict of all questions."""
        if not self.differences:
            return "same"
        return "near" if all(difference.near for difference in self.differences) else "different"


def verify(
    dataset: DatasetReader, plan: Plan, effort: PoolConfig, progress: Callable[[str, int], None]
) -> Verification:
    """Generate the instances of `plan` again and compare them. The plan is a subset of the dataset's plan."""
    job, differences, questions = job_of(plan, effort), list[Difference](), 0
    per_engine = plan.rows_of == "engines"
    tasks = {task.spec.name: task for task in plan.tasks}
    every = (
        [(own, name, piece) for piece in unit]
        for name, task in tasks.items()
        for own in [job.of(name)]
        for unit in batches(task.spec, plan.seed, task.indices)
    )
    with closing(map_batches(make_instances, every, effort, lambda p: weight(tasks[p[1]].spec, p[2]))) as outcomes:
        for (_, name, indices), made in outcomes:
            there = _stored_rows(dataset, name, indices)
            for at, index in enumerate(indices):
                here = made if isinstance(made, JobFailure) else {row["id"]: row for row in made.outcomes[at].rows}
                rejected = (
                    {}
                    if isinstance(made, JobFailure)
                    else {
                        identity(
                            plan.seed, r.task, r.index, r.question, r.engine if per_engine else None
                        ): f"{r.reason}: {r.detail}"
                        for r in made.outcomes[at].rejected
                    }
                )
                for engine in plan.row_engines:
                    for q in range(len(tasks[name].spec.questions)):
                        id_ = identity(plan.seed, name, index, q, engine)
                        differences += _compare(id_, there.get(id_), here, rejected)
                        questions += 1
                progress(name, 1)
    there_versions = dataset.manifest["versions"]
    versions = {n: (there_versions.get(n, "none"), v) for n, v in plan.versions.items() if there_versions.get(n) != v}
    return Verification(questions, tuple(sorted(differences, key=lambda d: d.id)), versions)


def _stored_rows(dataset: DatasetReader, task: str, indices: Sequence[int]) -> dict[str, Row]:
    """Return the dataset's rows of the given instances, by id."""
    columns = dataset.columns(task)
    return {row["id"]: row for row in dataset.rows(task, columns, set(indices))} if columns else {}


def _compare(
    id_: str, there: Row | None, here: Mapping[str, Row] | JobFailure, rejected: Mapping[str, str]
) -> Iterator[Difference]:
    """Yield the first difference of a question, if any."""
    if isinstance(here, JobFailure):
        yield Difference(id_, "", f"cannot be generated here: {here.reason}", False)
    elif there is None and id_ in here:
        yield Difference(id_, "", "rejected in the dataset, accepted here", False)
    elif there is not None and id_ not in here:
        yield Difference(id_, "", f"in the dataset, but rejected here ({rejected.get(id_, '')})", False)
    elif there is not None:
        differences = [d for name in there for d in _column(id_, name, there[name], here[id_].get(name))]
        yield from sorted(differences, key=lambda d: d.near)[:1]


def _column(id_: str, name: str, there: Any, here: Any) -> Iterator[Difference]:
    """Yield the difference of one column, if any."""
    if name in (*PICTURES, *CHANNELS):
        yield from _picture_differences(id_, name, there or [], here or [])
    elif (words := _value_difference(there, here)) is not None:
        yield Difference(id_, name, f"{_short(there)} in the dataset, {_short(here)} here{words[0]}", words[1])


def _value_difference(there: Any, here: Any) -> tuple[str, bool] | None:
    """Return a description of the difference of two values and whether it is small; None if they are equal."""
    if there == here or (isinstance(there, list | tuple) and list(there) == list(here or ())):
        return None
    a, b = _numbers(there), _numbers(here)
    if a is None or b is None or len(a) != len(b) or _without_numbers(there) != _without_numbers(here):
        return "", False
    gaps = [abs(x - y) for x, y in zip(a, b, strict=True)]
    near = all(math.isclose(x, y, rel_tol=NEAR_RELATIVE, abs_tol=NEAR_ABSOLUTE) for x, y in zip(a, b, strict=True))
    return f", {max(gaps):.2g} apart", near


def _numbers(value: Any) -> list[float] | None:
    """Return all floating-point numbers in a value, in order; None if it contains none."""
    if isinstance(value, float):
        return [value]
    parts = value.values() if isinstance(value, dict) else value if isinstance(value, list | tuple) else ()
    numbers = [number for part in parts for number in _numbers(part) or ()]
    return numbers or None


def _without_numbers(value: Any) -> Any:
    """Return a value with its floating-point numbers removed."""
    if isinstance(value, float):
        return None
    if isinstance(value, dict):
        return {name: _without_numbers(part) for name, part in value.items()}
    return [_without_numbers(part) for part in value] if isinstance(value, list | tuple) else value


def _short(value: Any) -> str:
    text = str(value)
    return text if len(text) <= 60 else f"{text[:57]}..."


def _picture_differences(id_: str, name: str, there: Sequence[Any], here: Sequence[Any]) -> Iterator[Difference]:
    """Yield the differences of a picture column."""
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
