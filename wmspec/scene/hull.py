"""The convex solids that stand for meshes and cones: computed once, so that every engine collides the same points."""

from __future__ import annotations

from math import pi
from typing import Any

import numpy as np
import trimesh

from wmspec.diagnostics import WmsError
from wmspec.scene.model import Array, Cone, Mesh

SIDES = 48
_MOST = 250  # the most vertices that all engines take, less a few
_DIRECTIONS = 240


def solid(mesh: Mesh) -> Any:
    """The convex hull of a mesh, as a `trimesh.Trimesh`. Raises WmsError if the mesh is flat."""
    points = np.asarray(mesh.points, float)
    spread = np.linalg.svd(points - points.mean(axis=0), compute_uv=False) if len(points) > 3 else np.zeros(3)
    if not spread[-1] > 1e-6 * spread[0]:
        raise WmsError("a mesh that collides must span a volume: its points lie in a plane, on a line or coincide")
    return trimesh.convex.convex_hull(points)


def corners(shape: Cone | Mesh) -> Array:
    """The corners (n, 3), n <= 250, of the convex solid that collides for `shape`, in the shape's frame."""
    return _cone(shape) if isinstance(shape, Cone) else _thinned(np.asarray(solid(shape).vertices, float))


def _cone(cone: Cone) -> Array:
    turn = np.arange(SIDES) * (2 * pi / SIDES)
    rim = np.stack([cone.radius * np.cos(turn), cone.radius * np.sin(turn), np.full(SIDES, -cone.height / 2)], axis=1)
    return np.vstack([rim, [0.0, 0.0, cone.height / 2]])


def _thinned(points: Array) -> Array:
    """At most 240 of the hull's corners: those furthest out in evenly spread directions (a Fibonacci sphere)."""
    if len(points) <= _MOST:
        return points
    i = np.arange(_DIRECTIONS) + 0.5
    z, turn = 1 - 2 * i / _DIRECTIONS, i * pi * (3 - np.sqrt(5))
    across = np.sqrt(1 - z**2)
    directions = np.stack([across * np.cos(turn), across * np.sin(turn), z], axis=1)
    furthest = np.unique((directions @ points.T).argmax(axis=1))
    kept: Array = points[furthest]
    return kept
