"""How deep points lie below flat and round surfaces, and how that grows with the point."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from wmspec.core.space import Vector
from wmspec.sim.shapes.hull import hull

Array = NDArray[np.float64]
Side = tuple[float, Array]


def below(faces: Iterable[tuple[Vector, float]], point: Array) -> list[Side]:
    """Below each of these planes: outward unit normals and how far (m) they are from the origin."""
    return [_flat(np.array(normal), offset, point) for normal, offset in faces]


def _flat(normal: Array, offset: float, point: Array) -> Side:
    """Below a plane."""
    return float(offset - normal @ point), -normal


def round_(radius: float, away: Array) -> Side:
    """Below a ball or a tube, seen from the nearest point (3,) of its middle."""
    distance = float(np.linalg.norm(away))
    return radius - distance, -away / distance if distance > 0 else np.zeros(3)


def of_hull(points: Array, point: Array) -> list[Side]:
    """Below the nearest face of the convex hull of points (n, 3)."""
    solid = hull(points)
    depths = np.einsum("ij,ij->i", solid.face_normals, solid.triangles[:, 0]) - solid.face_normals @ point
    nearest = int(depths.argmin())
    return [(float(depths[nearest]), -np.asarray(solid.face_normals[nearest]))]
