"""Flat meshes that collide, such as grounds made of one polygon: no engine collides them, so they get a thickness."""

from __future__ import annotations

import numpy as np

from wmspec.errors import WmsError
from wmspec.scene.model import Array, Mesh

THICKNESS = 0.01
"""How thick (m) a flat mesh is that never moves."""
_LEVEL = 0.1  # sine of the angle from upright from which on a sheet has an upper side


def thickened(sheet: Mesh, down: Array) -> Mesh:
    """A flat mesh as a solid whose upper side it is; if it stands upright, its front. `down` (3,) is a unit vector.

    Raises WmsError if its faces have no area.
    """
    points, back = np.unique(sheet.points, axis=0, return_inverse=True)
    faces = back.reshape(-1)[sheet.faces]
    normals = np.cross(points[faces[:, 1]] - points[faces[:, 0]], points[faces[:, 2]] - points[faces[:, 0]])
    areas = np.linalg.norm(normals, axis=1)
    if not areas.max() > 1e-12 * np.ptp(points, axis=0).max() ** 2:
        raise WmsError("its points lie on a line or coincide")
    behind = -normals[areas.argmax()] / areas.max()
    if abs(behind @ down) > _LEVEL:
        behind *= np.sign(behind @ down)
    faces, normals = faces[areas > 0], normals[areas > 0]
    faces = np.where((normals @ behind > 0)[:, None], faces[:, ::-1], faces)
    shift = len(points)
    sides = np.array([[(b, a, a + shift), (b, a + shift, b + shift)] for a, b in _rim(faces)]).reshape(-1, 3)
    solid = np.concatenate([faces, faces[:, ::-1] + shift, sides])
    return Mesh(np.concatenate([points, points + THICKNESS * behind]), solid.astype(np.int32))


def _rim(faces: Array) -> list[tuple[int, int]]:
    """The edges (from, to) of faces that no other face shares."""
    edges = {(int(f[i]), int(f[i - 2])) for f in faces for i in range(3)}
    return sorted(edge for edge in edges if edge[::-1] not in edges)
