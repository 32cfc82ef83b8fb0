"""Triangulations of shapes, equal for all engines, and their building blocks.

Round shapes have 48 segments. Normals are smooth up to creases of 40 degrees. Texture coordinates `st` follow USD (t =
0 at the bottom of the image): a round side is wrapped once around the axis, s from +x by the right-hand rule and t
upwards; flat caps and each face of a box show the whole image.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from math import cos, pi, radians, sin

import numpy as np
from numpy.typing import NDArray

from wmspec.core.space import Vector
from wmspec.sim.shapes.shape import Shape

Array = NDArray[np.float64]

SEGMENTS = 48
CREASE = radians(40)
RINGS = SEGMENTS // 4  # bands from the equator of a sphere to a pole

Row = tuple[float, float, float, float, float]  # radius, z, radial and z components of the normal, t


@dataclass(frozen=True, eq=False)
class Facets:
    """Triangles: `points`, unit `normals` (n, 3), `st` (n, 2), `faces` (m, 3) counter-clockwise from outside."""

    points: Array
    normals: Array
    st: Array
    faces: NDArray[np.int32]

    def __post_init__(self) -> None:
        for array in (self.points, self.normals, self.st, self.faces):
            array.setflags(write=False)


MAX_CACHED_SHAPES = 1024
"""Number of cached triangulations; a furnished room has about a hundred shapes, and a worker sees several rooms."""


@lru_cache(maxsize=MAX_CACHED_SHAPES)
def tessellate(shape: Shape) -> Facets:
    """Return the triangles of a shape in its own frame (m); equal shapes share one object."""
    return shape.facets()


def rounded(radius: float, height: float) -> Facets:
    """Return two hemispheres around a straight part of `height`; a sphere if it is 0."""
    length = pi * radius + height
    rows: list[Row] = []
    for end in (-1, 1):
        for ring in range(RINGS + 1):
            angle = (ring - RINGS * (end < 0)) * pi / 2 / RINGS
            along = radius * (angle + pi / 2) + height * (end > 0)
            rows.append(
                (radius * cos(angle), radius * sin(angle) + end * height / 2, cos(angle), sin(angle), along / length)
            )
    return lathe(rows if height > 0 else rows[: RINGS + 1] + rows[RINGS + 2 :])


def lathe(rows: list[Row]) -> Facets:
    """Return a profile, given from bottom to top, revolved around z."""
    r, z, out, up, t = np.array(rows, dtype=np.float64).T[:, :, None]
    s = np.linspace(0, 1, SEGMENTS + 1)[None, :]
    c, n = np.cos(2 * pi * s), np.sin(2 * pi * s)
    c[:, -1], n[:, -1] = c[:, 0], n[:, 0]  # close the seam exactly
    grid = np.broadcast_arrays(r * c, r * n, z, out * c, out * n, up, s, t)
    x, y, z, nx, ny, nz, s, t = (a.reshape(-1) for a in grid)
    first = (np.arange(len(rows) - 1)[:, None] * (SEGMENTS + 1) + np.arange(SEGMENTS)).reshape(-1)
    faces = quads(first, SEGMENTS + 1)
    return facets(np.stack([x, y, z], 1), np.stack([nx, ny, nz], 1), np.stack([s, t], 1), faces)


def disc(radius: float, z: float, sign: float) -> Facets:
    """Return a cap at height `z` that faces along `sign` times z."""
    angle = np.arange(SEGMENTS) * 2 * pi / SEGMENTS
    ring = np.stack([np.cos(angle), sign * np.sin(angle)], axis=1)
    flat = np.concatenate([np.zeros((1, 2)), ring])
    points = np.column_stack([radius * flat, np.full(len(flat), z)])
    this = np.arange(SEGMENTS)
    faces = np.stack([np.zeros(SEGMENTS, int), 1 + this, 1 + (this + 1) % SEGMENTS], axis=1)
    return facets(points, np.tile([0.0, 0.0, sign], (len(flat), 1)), 0.5 + flat * [0.5, 0.5 * sign], faces)


def side(half: Array, axis: int, sign: float) -> Facets:
    """Return one face of a box; the image is upright on the four sides and has +y up on top."""
    normal = np.zeros(3)
    normal[axis] = sign
    up = np.array([0.0, 0.0, 1.0]) if axis < 2 else np.array([0.0, 1.0, 0.0])
    right = np.cross(up, normal)
    st = np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0]])
    corner = normal + (2 * st[:, :1] - 1) * right + (2 * st[:, 1:] - 1) * up
    return facets(corner * half, np.tile(normal, (4, 1)), st, quads(np.array([0]), 2))


def quads(first: NDArray[np.integer], stride: int) -> NDArray[np.integer]:
    """Return two triangles for each grid cell, given its lower left corner; the next row is at +`stride`."""
    above = first + stride
    return np.concatenate([np.stack([first, first + 1, above + 1], 1), np.stack([first, above + 1, above], 1)])


def smooth(points: Array, faces: NDArray[np.int32], st: Array | None = None) -> Facets:
    """Return triangles with normals smoothed across edges below the crease angle.

    Without `st` (n, 2), the image is projected from above onto the bounding box.
    """
    p, f = np.asarray(points, np.float64), np.asarray(faces, np.int32)
    t = np.asarray(st, np.float64) if st is not None else _planar(p)
    area = np.cross(p[f[:, 1]] - p[f[:, 0]], p[f[:, 2]] - p[f[:, 0]])
    normals = _corner_normals(p, f, area)
    corner = np.concatenate([p[f.reshape(-1)], normals, t[f.reshape(-1)]], axis=1)
    _, first, index = np.unique(corner, axis=0, return_index=True, return_inverse=True)
    unique = corner[first]
    return facets(unique[:, :3], unique[:, 3:6], unique[:, 6:], index.reshape(-1, 3))


def _corner_normals(points: Array, faces: NDArray[np.int32], area: Array) -> Array:
    """Return unit normals (3 m, 3): area-weighted sums of the adjacent faces within the crease angle."""
    unit = area / np.maximum(np.linalg.norm(area, axis=1, keepdims=True), 1e-30)
    _, place = np.unique(np.round(points, 7), axis=0, return_inverse=True)
    around: dict[int, list[int]] = {}
    for corner, vertex in enumerate(place.reshape(-1)[faces.reshape(-1)].tolist()):
        around.setdefault(vertex, []).append(corner)
    normals = np.empty((faces.size, 3))
    for corners in around.values():
        face = np.array(corners) // 3
        near = (unit[face] @ unit[face].T > cos(CREASE)) | np.eye(len(face), dtype=bool)
        groups, group = np.unique(near, axis=0, return_inverse=True)
        normals[corners] = (groups @ area[face])[group.reshape(-1)]
    size: Array = np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-30)
    return normals / size


def _planar(points: Array) -> Array:
    """Return texture coordinates (n, 2) from above over the bounding box."""
    low, high = points[:, :2].min(axis=0), points[:, :2].max(axis=0)
    return np.asarray((points[:, :2] - low) / np.maximum(high - low, 1e-12))


def join(parts: list[Facets]) -> Facets:
    """Return the union of triangle sets."""
    start = np.cumsum([0] + [len(part.points) for part in parts[:-1]])
    return facets(
        np.concatenate([part.points for part in parts]),
        np.concatenate([part.normals for part in parts]),
        np.concatenate([part.st for part in parts]),
        np.concatenate([part.faces + at for part, at in zip(parts, start, strict=True)]),
    )


def translated(what: Facets, by: Vector) -> Facets:
    """Return the triangles moved by a vector."""
    return facets(what.points + np.array(by), what.normals, what.st, what.faces)


def facets(points: Array, normals: Array, st: Array, faces: NDArray[np.integer]) -> Facets:
    """Return facets without degenerate triangles (at poles), which some engines reject, and without unused points."""
    a, b, c = points[faces[:, 0]], points[faces[:, 1]], points[faces[:, 2]]
    twice = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    kept = faces[twice > 1e-9 * twice.max(initial=0.0)]
    used, renumbered = np.unique(kept, return_inverse=True)
    return Facets(points[used], normals[used], st[used], renumbered.reshape(-1, 3).astype(np.int32))
