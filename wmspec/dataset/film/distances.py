"""Distances of films: where each object is seen, in every frame, and how far two films are apart.

An object is located by three points of its mask: the centroid and the corners of its 5 % and 95 % quantiles. Centroids
alone hardly distinguish falling from sliding. Distances are in widths of the object, the square root of its area.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

#: The area (px) of the pictures in which films are compared: their size keeps its aspect.
WORKING_AREA = 256 * 256
#: Masks with fewer pixels count as absent.
MIN_PIXELS = 12
#: Largest distance of two points, and the distance of present and absent (widths).
CAP, ABSENT = 4.0, 2.0
#: Number of last frames that the distance of the end covers.
END_FRAMES = 3


def working_size(width: int, height: int) -> tuple[int, int]:
    """Return the width and height (px) in which films of this size are compared."""
    scale = min(1.0, (WORKING_AREA / (width * height)) ** 0.5)
    return max(16, round(width * scale)), max(16, round(height * scale))


def nearest_pixels(pictures: NDArray[Any], size: tuple[int, int]) -> NDArray[Any]:
    """Return pictures (..., h, w) at another size (px), each pixel the nearest one."""
    height, width = pictures.shape[-2:]
    rows = ((np.arange(size[1]) + 0.5) * height / size[1]).astype(int)
    columns = ((np.arange(size[0]) + 0.5) * width / size[0]).astype(int)
    return pictures[..., rows, :][..., columns]


def mask_points(mask: Mask) -> Array:
    """Return the three points (3, 2) of a mask (h, w), x and y in px; NaN if it is absent."""
    rows = np.flatnonzero(mask.any(axis=1))
    if not len(rows):
        return np.full((3, 2), np.nan)
    seen = slice(rows[0], rows[-1] + 1)  # a mask has few of the rows
    across, down = np.count_nonzero(mask[seen], axis=0), np.zeros(len(mask), np.intp)
    if across.sum() < MIN_PIXELS:
        return np.full((3, 2), np.nan)
    down[seen] = np.count_nonzero(mask[seen], axis=1)
    made = np.empty((3, 2))
    made[:, 0], made[:, 1] = _spread(across), _spread(down)
    return made


def _spread(counts: NDArray[np.intp]) -> tuple[float, float, float]:
    """Return the mean and the 5 % and 95 % quantiles (linear) of places, given how often each occurs."""
    total = counts.cumsum()
    size = int(total[-1])
    places = (size - 1) * 0.05, (size - 1) * 0.95
    ranks = [rank for place in places for rank in (int(place), min(int(place) + 1, size - 1))]
    a, b, c, d = total.searchsorted(ranks, side="right").tolist()
    mean = float(counts @ np.arange(len(counts))) / size
    return mean, _between(a, b, places[0] % 1), _between(c, d, places[1] % 1)


def _between(a: int, b: int, part: float) -> float:
    """Return the number that lies a part of the way from `a` to `b`, rounded as numpy.percentile does."""
    return a + (b - a) * part if part < 0.5 else b - (b - a) * (1 - part)


def object_points(ids: NDArray[np.int16], bodies: list[int]) -> tuple[Array, Array]:
    """Return the points (n, T, 3, 2) and the areas (n, T) in px of bodies, by their numbers in `ids` (T, h, w)."""
    points = np.full((len(bodies), len(ids), 3, 2), np.nan)
    areas = np.zeros((len(bodies), len(ids)))
    for k, body in enumerate(bodies):
        for t, frame in enumerate(ids):
            mask = frame == body
            points[k, t], areas[k, t] = mask_points(mask), mask.sum()
    return points, areas


def point_distance(a: Array, b: Array, widths: Array) -> Array:
    """Return the distance (n, T) of objects in two films, in widths (n): the mean of the three points."""
    gone = np.isnan(a[..., 0, 0]), np.isnan(b[..., 0, 0])
    gaps: Array = np.minimum(np.linalg.norm(a - b, axis=-1) / widths[:, None, None], CAP).mean(axis=-1)
    return np.asarray(np.where(gone[0] & gone[1], 0.0, np.where(gone[0] | gone[1], ABSENT, gaps)))


def end_distance(a: Array, b: Array, widths: Array) -> float:
    """Return the mean distance of two films over the last frames, in widths: that of the object that differs most."""
    return float(point_distance(a, b, widths)[:, -END_FRAMES:].mean(axis=1).max())


def film_distance(a: Array, b: Array, widths: Array) -> float:
    """Return the distance of two films, in widths: that of the object that differs most.

    The distance of an object is the mean of that over the whole way and that over the last frames. In a mean over
    objects, those that move alike in both films would hide one that does not.
    """
    gaps = point_distance(a, b, widths)
    return float((gaps.mean(axis=1) + gaps[:, -END_FRAMES:].mean(axis=1)).max() / 2)


def widths_of(areas: list[Array]) -> Array:
    """Return the width (n) of each object (px) from its areas (n, T) in several films."""
    largest = np.stack([area.max(axis=1) for area in areas])
    return np.asarray(np.sqrt(np.maximum(np.median(largest, axis=0), 1.0)))


def pairwise(points: list[Array], widths: Array) -> Array:
    """Return the distances (k, k) of k films."""
    return np.array([[film_distance(a, b, widths) for b in points] for a in points])
