"""Meshes that collide as surfaces, such as rooms, bins, stairs and single-polygon grounds.

Not all engines collide non-convex geometry. So each flat face becomes a thin convex solid behind it; the front surface
is exact.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import trimesh
from scipy.spatial import ConvexHull

from wmspec.core.diagnostics import WmsError
from wmspec.sim.scene.model import Array
from wmspec.sim.shapes import Mesh

SHELL_DEPTH = 0.01
"""m: depth of the solid behind a face; less behind narrow faces and in thin solids."""
MAX_FACES = 2000
"""Number of faces of one mesh that engines collide in reasonable time."""
_NARROW = 1e-5  # m: narrower gaps let nothing through
_LEVEL = 0.1  # sine of the angle to the vertical above which a face has an upper side
_SMOOTH = 1e-4  # rad: largest angle between triangles of one face
_FLAT = 1e-6  # relative to the size: largest distance of corners from the plane


def thin_shells(mesh: Mesh, down: Array | None = None) -> tuple[Mesh, ...]:
    """Return thin convex solids, one behind each flat face of a mesh.

    For a closed solid, behind is inside. For other meshes the front is the counter-clockwise side; with a unit vector
    `down` (3,), faces that are not upright face up, because grounds are authored either way.

    Raises WmsError if the mesh has no area or too many faces.
    """
    whole = trimesh.Trimesh(mesh.points, mesh.faces)
    whole.update_faces(whole.area_faces > 1e-12 * np.ptp(mesh.points, axis=0).max() ** 2)
    if not len(whole.faces):
        raise WmsError("its points lie on a line or coincide")
    if whole.is_volume:
        faces = [(c, n, min(SHELL_DEPTH, _thick(whole, c.mean(axis=0), -n) / 2)) for c, n in _faces(whole)]
    else:
        faces = [(c, n if down is None else _fronted(n, down), SHELL_DEPTH) for c, n in _faces(whole)]
    made = tuple(solid for face in faces if (solid := _solid(*face)))
    if len(made) > MAX_FACES:
        raise WmsError(f"it has {len(made):,} flat faces, and engines collide at most {MAX_FACES:,} of a mesh")
    return made


def _fronted(normal: Array, down: Array) -> Array:
    upright = abs(normal @ down) <= _LEVEL
    return normal if upright else -normal * np.sign(normal @ down)


def _faces(whole: trimesh.Trimesh) -> Iterator[tuple[Array, Array]]:
    """Yield corners (n, 3), in order, and normal (3,) of each face.

    A face is a triangle, or several that form a convex polygon.
    """
    level = whole.face_adjacency[whole.face_adjacency_angles < _SMOOTH]
    for group in trimesh.graph.connected_components(level, nodes=np.arange(len(whole.faces))):
        normal = whole.face_normals[group[0]]
        corners = whole.vertices[np.unique(whole.faces[group])]
        outline, area = _outline(corners, normal)
        off = np.abs((corners - corners[0]) @ normal).max()
        if off < _FLAT * whole.scale and np.isclose(area, whole.area_faces[group].sum(), rtol=1e-6):
            yield outline, normal
        else:
            yield from ((whole.vertices[whole.faces[face]], whole.face_normals[face]) for face in group)


def _outline(corners: Array, normal: Array) -> tuple[Array, float]:
    """Return the convex polygon around coplanar points (n, 3): counter-clockwise corners, and area."""
    flat = corners @ trimesh.geometry.plane_transform(np.zeros(3), normal)[:2, :3].T
    hull = ConvexHull(flat, qhull_options="QJ")
    return corners[hull.vertices], float(hull.volume)


def _solid(corners: Array, normal: Array, most: float) -> Mesh | None:
    """Return a polygon with a smaller one behind it, so that adjacent solids do not protrude.

    Its depth is at most `most` (m). None if the polygon is too narrow.
    """
    middle = corners.mean(axis=0)
    edges = np.roll(corners, -1, axis=0) - corners
    width = (np.linalg.norm(np.cross(edges, middle - corners), axis=1) / np.linalg.norm(edges, axis=1)).min()
    if width < _NARROW:
        return None
    depth = min(most, width / 2)
    back = middle + (corners - middle) * (1 - depth / width) - depth * normal
    hull = trimesh.convex.convex_hull(np.concatenate([corners, back]))
    return Mesh(np.asarray(hull.vertices, np.float64), np.asarray(hull.faces, np.int32))


def _thick(whole: trimesh.Trimesh, start: Array, way: Array) -> float:
    """Return the distance (m) through a solid from a point on its surface.

    Source: Möller and Trumbore, "Fast, Minimum Storage Ray/Triangle Intersection", Journal of Graphics Tools 2 (1997).
    """
    first = whole.triangles[:, 0]
    one, two = whole.triangles[:, 1] - first, whole.triangles[:, 2] - first
    across = np.cross(way, two)
    with np.errstate(divide="ignore", invalid="ignore"):
        scale = 1 / (one * across).sum(axis=1)
        u = scale * ((start - first) * across).sum(axis=1)
        around = np.cross(start - first, one)
        v, far = scale * (around @ way), scale * (two * around).sum(axis=1)
        hit = (u >= 0) & (v >= 0) & (u + v <= 1) & (far > _FLAT * whole.scale)
    return float(far[hit].min(initial=np.inf))
