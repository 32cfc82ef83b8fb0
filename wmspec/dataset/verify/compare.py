"""Comparison of a row and of films with the same made again."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import uniform_filter

from wmspec.core.diagnostics import WmsError
from wmspec.core.safe_io import load_image, read_bytes
from wmspec.dataset.build.images import PNG, WEBP
from wmspec.dataset.build.reader import CHANNELS, PICTURES, DatasetReader
from wmspec.dataset.build.rows import Row
from wmspec.dataset.film.codec import decode
from wmspec.dataset.verify.model import Difference
from wmspec.runtime.questions.model import FAILED, Rejected
from wmspec.runtime.workers.pool import JobFailure

#: Relative and absolute (SI units) tolerance within which numbers are nearly equal.
NEAR_RELATIVE, NEAR_ABSOLUTE = 0.01, 1e-3
#: Mean absolute difference of pixel values (0 to 255) below which pictures are nearly equal: of the whole picture, and
#: of any square of `PATCH` pixels, which an edge that moves by a pixel does not reach.
NEAR_PIXELS, NEAR_PATCH, PATCH = 2.0, 100.0, 5


def compare(
    id_: str, there: Row | None, here: Row | Rejected | JobFailure | None, rejection: Rejected | None
) -> Iterator[Difference]:
    """Yield the first difference of a question, if any.

    `there` is the row in the dataset, or None with the `rejection` in its manifest.
    """
    if isinstance(here, JobFailure):
        yield Difference(id_, "", f"cannot be generated here: {here.reason}")
    elif there is None and not isinstance(here, Rejected):
        yield Difference(id_, "", "rejected in the dataset, accepted here")
    elif there is None and isinstance(here, Rejected):
        yield from _rejections(id_, rejection, here)
    elif there is not None and (here is None or isinstance(here, Rejected)):
        reason = f"{here.reason}: {here.detail}" if here is not None else ""
        yield Difference(id_, "", f"in the dataset, but rejected here ({reason})")
    elif there is not None and isinstance(here, dict):
        names = [*there, *(name for name in here if name not in there)]
        differences = [d for name in names for d in _column(id_, name, there.get(name), here.get(name))]
        yield from sorted(differences, key=lambda d: d.near)[:1]


def _rejections(id_: str, there: Rejected | None, here: Rejected) -> Iterator[Difference]:
    """Yield the difference of two rejections; failures depend on the machine."""
    if there is None or FAILED & {there.reason, here.reason} or there == here:
        return
    words = f"rejected in the dataset ({there.reason}: {there.detail}), here ({here.reason}: {here.detail})"
    yield Difference(id_, "", words, there.reason == here.reason)


def _column(id_: str, name: str, there: Any, here: Any) -> Iterator[Difference]:
    """Yield the difference of one column, if any."""
    if name in (*PICTURES, *CHANNELS):
        yield from _picture_differences(id_, name, there or [], here or [])
    elif (words := _value_difference(there, here)) is not None:
        yield Difference(id_, name, f"{_short(there)} in the dataset, {_short(here)} here{words[0]}", words[1])


def _value_difference(there: Any, here: Any) -> tuple[str, bool] | None:
    """Return a description of the difference of two values and whether it is small; None if they are equal."""
    if equal_values(there, here):
        return None
    a, b = _numbers(there), _numbers(here)
    if a is None or b is None or len(a) != len(b) or _without_numbers(there) != _without_numbers(here):
        return "", False
    gaps = [abs(x - y) for x, y in zip(a, b, strict=True) if not math.isnan(x - y)]
    near = all(math.isclose(x, y, rel_tol=NEAR_RELATIVE, abs_tol=NEAR_ABSOLUTE) for x, y in zip(a, b, strict=True))
    return f", {max(gaps, default=0):.2g} apart", near


def equal_values(there: Any, here: Any) -> bool:
    """Whether two values of a column are equal. A tuple equals a list, and NaN equals NaN."""
    if isinstance(there, list | tuple) and isinstance(here, list | tuple):
        return len(there) == len(here) and all(map(equal_values, there, here))
    if isinstance(there, dict) and isinstance(here, dict):
        return there.keys() == here.keys() and all(equal_values(there[name], here[name]) for name in there)
    if isinstance(there, float) and isinstance(here, float) and math.isnan(there):
        return math.isnan(here)
    return bool(there == here)


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
        yield Difference(id_, name, f"{len(there)} pictures in the dataset, {len(here)} here")
        return
    for number, (a, b) in enumerate(zip(there, here, strict=True), 1):
        if a == b:
            continue
        try:
            apart = pixel_difference(a["bytes"], b["bytes"])
        except WmsError as error:
            yield Difference(id_, name, f"picture {number} {error}")
            continue
        if apart is None:
            yield Difference(id_, name, f"picture {number} has another size here")
            continue
        near = apart.mean() < NEAR_PIXELS and float(_patches(apart).max()) < NEAR_PATCH
        words = f"picture {number} differs in {(apart > 0).mean():.2%} of its values, by {apart.mean():.2g} on average"
        if not apart.any():
            words = f"picture {number} is encoded in another way: {len(a['bytes'])} and {len(b['bytes'])} bytes"
        yield Difference(id_, name, words, bool(near))


def pixel_difference(there: bytes, here: bytes) -> NDArray[np.float64] | None:
    """Return the absolute differences of two pictures (0 to 255 for 8 bits), or None if their shapes differ.

    Raises WmsError if one cannot be decoded.
    """
    x, y = (np.asarray(load_image(one, PNG, WEBP), np.float64) for one in (there, here))
    return np.abs(x - y) if x.shape == y.shape else None


def _patches(apart: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the mean difference of the square around every pixel (h, w)."""
    flat = apart.reshape(*apart.shape[:2], -1).max(axis=2)
    return np.asarray(uniform_filter(flat, PATCH, mode="constant"))


def option_scores(there: Row, here: Mapping[str, Any]) -> list[float] | None:
    """Return how much each option's picture differs from the same picture made again; None without pictures."""
    a, b = there.get("option_image") or [], here.get("option_image") or []
    if len(a) < 2 or len(a) != len(b):
        return None
    scores = []
    for x, y in zip(a, b, strict=True):
        try:
            apart = pixel_difference(x["bytes"], y["bytes"])
        except WmsError:
            return None
        if apart is None:
            return None
        scores.append(float(apart.mean()) + abs(len(x["bytes"]) - len(y["bytes"])) * 1e-9)
    return scores


def film_differences(dataset: DatasetReader, films: Mapping[str, bytes]) -> Iterator[Difference]:
    """Yield the differences of films from those made again; equal frames in other bytes are equal films."""
    known = dataset.films
    for path in sorted(films):
        if path not in known:
            yield Difference(path, "", "the film is not in the dataset")
            continue
        there = read_bytes(dataset.folder / path)
        if there == films[path]:
            continue
        try:
            x, y = (decode(content).astype(np.float64) for content in (there, films[path]))
        except WmsError as error:
            yield Difference(path, "", str(error))
            continue
        if x.shape != y.shape:
            yield Difference(path, "", f"the film is {x.shape} in the dataset, {y.shape} here")
        elif (apart := np.abs(x - y)).any():
            words = f"the film differs in {(apart > 0).mean():.2%} of its values, by {apart.mean():.2g} on average"
            yield Difference(path, "", words, bool(apart.mean() < NEAR_PIXELS))
