"""Reusable lists for PyBullet, which leaks two references to each list and inner list that it receives.

All calls share the same inner lists with changing numbers, so the leak is bounded.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from wmspec.sim.scene.model import Array
from wmspec.sim.shapes.facets import Facets

_rows: dict[str, list[list[float]]] = {"vertices": [], "normals": [], "uvs": []}


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
