"""Convex hulls for shapes that engines lack, computed once so that all engines collide the same points."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from math import pi
from typing import Any

import numpy as np
from numpy.typing import NDArray

from wmspec.core.diagnostics import WmsError
from wmspec.core.space import Vector

Array = NDArray[np.float64]

_MAX_CORNERS = 250  # PhysX cooks at most 255 vertices
_DIRECTIONS = 240


def hull(points: Array) -> Any:
    """Return the convex hull of points (n, 3) as a `trimesh.Trimesh`. Raises WmsError if they are coplanar."""
    return _hull(np.ascontiguousarray(points, np.float64).tobytes())


@lru_cache(maxsize=256)
def _hull(numbers: bytes) -> Any:
    points = np.frombuffer(numbers).reshape(-1, 3)
    spread = np.linalg.svd(points - points.mean(axis=0), compute_uv=False) if len(points) > 3 else np.zeros(3)
    if not spread[-1] > 1e-6 * spread[0]:
        raise WmsError("a mesh that collides must span a volume: its points lie in a plane, on a line or coincide")
    import trimesh

    return trimesh.convex.convex_hull(points)


def limit_corners(solid: Any, also: Sequence[Vector] = ()) -> Array:
    """Return at most 240 corners of a hull with more than 250: the extreme ones in evenly spread directions.

    Directions are a Fibonacci sphere plus up to ten given ones.
    """
    points = np.asarray(solid.vertices, float)
    if len(points) <= _MAX_CORNERS:
        return points
    i = np.arange(_DIRECTIONS) + 0.5
    z, turn = 1 - 2 * i / _DIRECTIONS, i * pi * (3 - np.sqrt(5))
    across = np.sqrt(1 - z**2)
    directions = np.stack([across * np.cos(turn), across * np.sin(turn), z], axis=1)
    directions = np.concatenate([directions, np.reshape(also, (-1, 3))])
    furthest = np.unique((directions @ points.T).argmax(axis=1))
    kept: Array = points[furthest]
    return kept
