"""Triangles: what a mesh is, and whether it is flat or convex."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from wmspec.importers.model import Array


@dataclass(frozen=True, eq=False)
class Triangles:
    """Points (n, 3) in metres, faces (m, 3) of their indices, texture coordinates (n, 2) or None."""

    points: Array
    faces: NDArray[np.int64]
    st: Array | None


def is_flat(found: Triangles) -> bool:
    """Whether all points lie in a plane, within 1e-6 of the mesh's size."""
    spread = np.linalg.svd(found.points - found.points.mean(axis=0), compute_uv=False)
    return len(spread) < 3 or not spread[-1] > 1e-6 * spread[0]


def is_convex(found: Triangles) -> bool:
    """Whether no point is in front of any face, within 1e-5 of the mesh's size. What is very large is taken for not."""
    points, faces = found.points, found.faces
    if len(points) * len(faces) > 2e9:
        return False
    near = 1e-5 * float(np.ptp(points, axis=0).max())
    for some in np.array_split(faces, 1 + len(points) * len(faces) // 4_000_000):
        a, b, c = (points[some[:, i]] for i in range(3))
        normals = np.cross(b - a, c - a)
        normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-300)
        if (normals @ points.T - (normals * a).sum(axis=1)[:, None]).max(initial=0.0) > near:
            return False
    return True
