"""Sizes of mesh files that assets name: their convex hulls, and whether they are flat."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from wmspec.core.diagnostics import WmsError
from wmspec.lang.importers.mesh_files import check_mesh_file
from wmspec.lang.importers.model import MeshFile
from wmspec.sim.scene.model import Array
from wmspec.sim.shapes import Mesh
from wmspec.sim.shapes.hull import hull

_NO_FACES = np.empty((0, 3), np.int32)


@dataclass(frozen=True)
class MeshSize:
    """The extreme points (n, 3) m of a mesh; `hull` is None if they lie in a plane."""

    points: Array
    hull: Mesh | None


def mesh_size(folder: Path, form: MeshFile) -> MeshSize | None:
    """Return the size of a scaled mesh, or None if it cannot be read or lies in a stage."""
    if "#" in form.file:
        return None
    path = folder / form.file
    try:
        status = path.stat()
        points = _points(str(path), status.st_mtime_ns, status.st_size)
    except Exception:  # noqa: BLE001  whoever loads the mesh reports it
        return None
    scaled = points * np.asarray(form.scale, np.float64)
    try:
        solid = hull(scaled)
    except WmsError:
        return MeshSize(scaled, None)
    corners = np.asarray(solid.vertices, np.float64)
    return MeshSize(corners, Mesh(corners, _NO_FACES))


@lru_cache(maxsize=512)
def _points(path: str, _changed: int, _size: int) -> Array:
    """Return the points (n, 3) m of a file, those of its hull if it has one."""
    import trimesh

    check_mesh_file(Path(path))
    loaded: Any = trimesh.load(path, force="mesh", process=False, skip_materials=True)
    points = np.asarray(loaded.vertices, np.float64)
    if path.lower().endswith(".dae"):
        points = points * trimesh.units.unit_conversion(loaded.units, "m")
    if not len(points) or not np.isfinite(points).all():
        raise ValueError("it has no finite points")
    try:
        return np.asarray(hull(points).vertices, np.float64)
    except WmsError:
        return points
