"""The links of an arm behind its hand, as points on what is drawn of them."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
import trimesh
from pxr import Usd, UsdGeom

from wmspec.compile.robots.arm import Arm, Array
from wmspec.core.resources import resource

GRID = 0.02  # m: no part of a link's surface is further than that from one of its points


@lru_cache(maxsize=8)
def limbs(arm: Arm) -> tuple[tuple[int, Array], ...]:
    """What there is of each moving link: its number among the frames of `Arm.links`, and points (n, 3) m in that frame.

    What is within the hull of the hand or ahead of it is left out, and the base, which moves nowhere.
    """
    stage = Usd.Stage.Open(str(resource(arm.asset)))
    root, cache, last = stage.GetDefaultPrim(), UsdGeom.XformCache(), len(arm.frames) + 1
    found = []
    for number in range(1, last + 1):
        link = root.GetChild("hand" if number == last else f"link{number}")
        points = [_points(cache, link, prim) for prim in Usd.PrimRange(link) if prim.IsA(UsdGeom.Mesh)] if link else []
        every = np.concatenate([np.empty((0, 3)), *points])
        if number == last:
            every = every[every[:, 2] < arm.hull[0, 2]]
        if len(every):
            found.append((number, every))
    return tuple(found)


def _points(cache: UsdGeom.XformCache, link: Usd.Prim, prim: Usd.Prim) -> Array:
    """Points on a mesh, seen from its link, one for each cell of a grid."""
    mesh = UsdGeom.Mesh(prim)
    corners = np.asarray(mesh.GetPointsAttr().Get(), np.float64)
    faces = np.asarray(mesh.GetFaceVertexIndicesAttr().Get()).reshape(-1, 3)
    fine = trimesh.remesh.subdivide_to_size(corners, faces, GRID, max_iter=20)[0]
    matrix = np.asarray(cache.ComputeRelativeTransform(prim, link)[0])
    seen = np.asarray(fine @ matrix[:3, :3] + matrix[3, :3], np.float64)
    _, first = np.unique(np.floor(seen / GRID).astype(np.int64), axis=0, return_index=True)
    return seen[np.sort(first)]
