"""What TinyRenderer need not draw: it draws the backs of things too, though nobody can see them.

A body of few flat sides (a floor, a box) is therefore given to it side by side, and only those in view are put in
place.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from wmspec.sim.scene.model import Array
from wmspec.sim.shapes.facets import Facets

FEW = 8
EVERYWHERE = np.array([0.0, 0.0, 0.0, 1.0])
"""The plane that every point is in front of."""


def sides(facets: Facets) -> list[tuple[Facets, Array]]:
    """The triangles of each flat side with its plane (4,): what is in front of it has `plane @ (x, y, z, 1) > 0`.

    A body of more than `FEW` sides stays whole.
    """
    a, b, c = facets.points[facets.faces.T]
    normal = np.cross(b - a, c - a)
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    plane = np.column_stack([normal, -np.sum(normal * a, axis=1)])
    planes, which = np.unique(np.round(plane, 9), axis=0, return_inverse=True)
    if len(planes) > FEW:
        return [(facets, EVERYWHERE)]
    return [(_part(facets, which.reshape(-1) == i), one) for i, one in enumerate(planes)]


def _part(facets: Facets, chosen: NDArray[np.bool_]) -> Facets:
    used, faces = np.unique(facets.faces[chosen], return_inverse=True)
    return Facets(facets.points[used], facets.normals[used], facets.st[used], faces.reshape(-1, 3).astype(np.int32))
