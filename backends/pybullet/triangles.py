"""Triangles for PyBullet: back-face culling, and reusable lists.

TinyRenderer draws invisible back faces too. So a body with few flat sides (floor, box) is added side by side, and only
visible sides are placed.

PyBullet leaks two references to each list and inner list that it receives. All calls share the same inner lists with
changing numbers, so the leak is bounded.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np
from numpy.typing import NDArray

from wmspec.sim.scene.model import Array
from wmspec.sim.shapes.facets import Facets

_rows: dict[str, list[list[float]]] = {"vertices": [], "normals": [], "uvs": []}

MAX_SIDES = 8
ALWAYS_VISIBLE = np.array([0.0, 0.0, 0.0, 1.0])
"""A plane with every point in front."""


def split_by_plane(facets: Facets) -> list[tuple[Facets, Array]]:
    """Return the triangles of each flat side with its plane (4,); points in front have `plane @ (x, y, z, 1) > 0`.

    A body with more than `MAX_SIDES` sides stays whole.
    """
    a, b, c = facets.points[facets.faces.T]
    normal = np.cross(b - a, c - a)
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    plane = np.column_stack([normal, -np.sum(normal * a, axis=1)])
    planes, which = np.unique(np.round(plane, 9), axis=0, return_inverse=True)
    if len(planes) > MAX_SIDES:
        return [(facets, ALWAYS_VISIBLE)]
    return [(_part(facets, which.reshape(-1) == i), one) for i, one in enumerate(planes)]


def _part(facets: Facets, chosen: NDArray[np.bool_]) -> Facets:
    used, faces = np.unique(facets.faces[chosen], return_inverse=True)
    return Facets(facets.points[used], facets.normals[used], facets.st[used], faces.reshape(-1, 3).astype(np.int32))


@contextmanager
def shared_lists(facets: Facets) -> Iterator[dict[str, list[list[float]] | list[int]]]:
    """Return arguments of `createVisualShape` for triangles; valid within the context."""
    arguments: dict[str, list[list[float]] | list[int]] = {
        "vertices": _fill("vertices", facets.points),
        "normals": _fill("normals", facets.normals),
        "uvs": _fill("uvs", facets.st),
        "indices": facets.faces.ravel().tolist(),
    }
    try:
        yield arguments
    finally:
        for values in arguments.values():
            values.clear()


def _fill(name: str, array: Array) -> list[list[float]]:
    rows = _rows[name]
    rows.extend([] for _ in range(len(array) - len(rows)))
    for row, values in zip(rows, array.tolist(), strict=False):
        row[:] = values
    return rows[: len(array)]
