"""Lists for PyBullet, which never gives back two references to each list, and each list in it, that it is given.

So all calls are given the same inner lists, with other numbers in them: they exist once, and can't be lost again.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from wmspec.sim.scene.model import Array
from wmspec.sim.shapes.facets import Facets

_rows: dict[str, list[list[float]]] = {"vertices": [], "normals": [], "uvs": []}


@contextmanager
def lists(facets: Facets) -> Iterator[dict[str, list[list[float]] | list[int]]]:
    """The arguments of `createVisualShape` for these triangles; valid until the context is left."""
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
