"""Depths of points below flat and round surfaces, with gradients."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from wmspec.core.space import Vector
from wmspec.sim.shapes.hull import hull

Array = NDArray[np.float64]
Side = tuple[float, Array]


def plane_depths(faces: Iterable[tuple[Vector, float]], point: Array) -> list[Side]:
    """Return the depths below planes, given outward unit normals and distances (m) from the origin."""
    return [_flat(np.array(normal), offset, point) for normal, offset in faces]


def _flat(normal: Array, offset: float, point: Array) -> Side:
    """Return the depth below a plane."""
    return float(offset - normal @ point), -normal


def round_depth(radius: float, away: Array) -> Side:
    """Return the depth below a sphere or tube, relative to the nearest point (3,) of its core."""
    distance = float(np.linalg.norm(away))
    return radius - distance, -away / distance if distance > 0 else np.zeros(3)


def hull_depths(points: Array, point: Array) -> list[Side]:
    """Return the depth below the nearest face of the convex hull of points (n, 3)."""
    solid = hull(points)
    depths = np.einsum("ij,ij->i", solid.face_normals, solid.triangles[:, 0]) - solid.face_normals @ point
    nearest = int(depths.argmin())
    return [(float(depths[nearest]), -np.asarray(solid.face_normals[nearest]))]
