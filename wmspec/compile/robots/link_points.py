"""Point clouds of the links of an arm behind its hand, for collision checks."""

from __future__ import annotations

import io
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from wmspec.compile.robots.arm import Arm, Array
from wmspec.core import disk_cache
from wmspec.core.resources import resource

if TYPE_CHECKING:  # imported only to fill the cache
    from pxr import Usd, UsdGeom

GRID_SIZE = 0.02  # m: maximum distance of the surface from a point


@lru_cache(maxsize=8)
def link_points(arm: Arm) -> tuple[tuple[int, Array], ...]:
    """Return for each moving link its index in `Arm.links`, and surface points (n, 3) m in its frame.

    The base and points within or ahead of the hand's hull are omitted.
    """
    if Path(arm.asset).is_absolute():  # not cached: files that a user's asset refers to may change
        return _link_points(arm)
    key = f"{disk_cache.fingerprint()} {arm.asset} {len(arm.frames)} {arm.hull[0].tolist()}"
    entry = f"links-{disk_cache.digest(key.encode())[:32]}.npz"
    if (content := disk_cache.read(entry)) is not None:
        with np.load(io.BytesIO(content), allow_pickle=False) as arrays:
            each = np.split(arrays["points"], arrays["stops"][:-1])
            return tuple(zip(arrays["numbers"].tolist(), each, strict=True))
    found, made = _link_points(arm), io.BytesIO()
    points = [points for _, points in found]
    np.savez(
        made,
        numbers=np.array([number for number, _ in found]),
        points=np.concatenate(points),
        stops=np.cumsum([len(each) for each in points]),
    )
    disk_cache.write(entry, made.getvalue())
    return found


def _link_points(arm: Arm) -> tuple[tuple[int, Array], ...]:
    from pxr import Usd, UsdGeom

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
    """Return points on a mesh in the frame of its link, one for each grid cell."""
    import trimesh
    from pxr import UsdGeom

    mesh = UsdGeom.Mesh(prim)
    corners = np.asarray(mesh.GetPointsAttr().Get(), np.float64)
    faces = np.asarray(mesh.GetFaceVertexIndicesAttr().Get()).reshape(-1, 3)
    fine = trimesh.remesh.subdivide_to_size(corners, faces, GRID_SIZE, max_iter=20)[0]
    matrix = np.asarray(cache.ComputeRelativeTransform(prim, link)[0])
    seen = np.asarray(fine @ matrix[:3, :3] + matrix[3, :3], np.float64)
    _, first = np.unique(np.floor(seen / GRID_SIZE).astype(np.int64), axis=0, return_index=True)
    return seen[np.sort(first)]
