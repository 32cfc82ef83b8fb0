"""Meshes from files: triangles in metres, and the convex hull used for support and mass."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import lru_cache
from typing import TYPE_CHECKING, Any

from wmspec.core.diagnostics import ImpossibleValue, WmsError
from wmspec.core.limits import POINTS
from wmspec.core.space import Vector
from wmspec.lang.check.tables.vocabulary import FILES, MAX_LENGTH, STAGES
from wmspec.lang.importers.mesh_files import check_mesh_file
from wmspec.lang.importers.prim_names import split_prim_name
from wmspec.lang.parse.files import resolve_display_path
from wmspec.sim.shapes import Mesh

if TYPE_CHECKING:  # imported late: most specs have no meshes, and importing numpy slows their check
    import numpy as np
    from numpy.typing import NDArray

#: Axes of the file along x, y and z of the object, and their signs, by the axis that points up: a turn about x or y.
_AXES, _SIGNS = {"x": (2, 1, 0), "y": (0, 2, 1)}, {"x": (-1.0, 1.0, 1.0), "y": (1.0, -1.0, 1.0)}


@dataclass(frozen=True, eq=False)
class FileMesh(Mesh):
    """The mesh of a file and its collision geometry: all points within `radius` (m) of the hull of `touched` (n, 3).

    `touched` holds the corners of the mesh's hull, or of its bounding box, or the centre of its bounding sphere. `room`
    (m³) is the volume of the mesh's own hull, 0 if it is flat.
    """

    touched: NDArray[np.float64] = field(kw_only=True)
    room: float = field(kw_only=True)
    radius: float = field(kw_only=True)

    @property
    def outline(self) -> NDArray[np.float64]:
        """Points of the collision geometry (n, 3)."""
        return self.touched

    @property
    def volume(self) -> float:
        """Volume (m³) of the mesh's hull, independent of the collision geometry."""
        return self.room

    def reach(self, direction: Vector) -> float:
        """Return the support distance (m) of the collision geometry."""
        return super().reach(direction) + self.radius * math.hypot(*direction)

    def bounds(self, turn: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the bounds of the collision geometry."""
        import numpy as np

        return np.asarray(super().bounds(turn) + np.array([[-self.radius], [self.radius]]))


def load(
    path: str, scale: float | Vector, collision: str, solid: bool, *, metres: float | None = None, up: str = "z"
) -> FileMesh:
    """Return the mesh of a file, turned so that its axis `up` is z, and scaled by `scale` (uniform or per axis).

    `collision` is the mode of its collision geometry. A unit of the file is `metres` long; by default as the file
    declares, or 1. Files are cached.

    Raises: ImpossibleValue: if the file is missing, unsupported or broken, or has no volume though it is `solid`.
    """
    name, prim = split_prim_name(path)
    file = resolve_display_path(name)
    if file.suffix.lower() not in (STAGES if prim else FILES["file"]):
        raise ImpossibleValue(
            f"{file.name} is not a supported mesh file", help=f"use one of {', '.join(FILES['file'])}"
        )
    try:
        status = file.stat()
    except OSError as error:
        raise ImpossibleValue(f"{name} cannot be read: {error.strerror}") from None
    import numpy as np

    with np.errstate(all="ignore"):  # extreme numbers are checked in `_load`
        made = _load(path, status.st_mtime_ns, status.st_size, scale, collision, metres, up)
    if solid and made.volume <= 0 and collision != "surface":
        raise ImpossibleValue(f"{path} has no volume", help="use a mesh that is not flat")
    return made


@lru_cache(maxsize=256)
def _load(
    path: str, _changed: int, _size: int, scale: float | Vector, collision: str, metres: float | None, up: str
) -> FileMesh:
    import numpy as np

    stretch = np.broadcast_to(np.asarray(scale, float), 3)
    whole = _of_stage(path, metres) if split_prim_name(path)[1] else _of_file(path, metres)
    points = whole.points if up == "z" else whole.points[:, _AXES[up]] * _SIGNS[up]
    points, faces = points * stretch, whole.faces[:, :: -1 if np.sign(stretch).prod() < 0 else 1]
    low, high = points.min(axis=0), points.max(axis=0)
    if not (size := float((high - low).max())) <= MAX_LENGTH:
        what = f"{size / 1000:g} km large with this scale; the most is {MAX_LENGTH / 1000:g} km"
        raise ImpossibleValue(f"{path} is {what}")
    hull, volume = _hull(path, points)
    touched, radius = hull, 0.0
    if collision == "bounds":
        touched = np.array(np.meshgrid(*zip(low, high, strict=True))).reshape(3, -1).T
    if collision == "ball":
        touched = (low + high)[None] / 2
        radius = float(np.linalg.norm(points - touched, axis=1).max())
    return FileMesh(points, np.asarray(faces, np.int32), whole.st, touched=touched, room=volume, radius=radius)


def _of_stage(path: str, metres: float | None) -> Mesh:
    """Return the triangles of the mesh in a USD file, which has its own unit. Raises ImpossibleValue if broken."""
    from wmspec.lang.importers.usd_file import mesh

    name, prim = split_prim_name(path)
    read = mesh(resolve_display_path(name), None, name, prim)
    if isinstance(read, tuple):
        raise ImpossibleValue("; ".join(f"{mistake.place}: {mistake.message}" for mistake in read))
    if metres is not None:
        raise ImpossibleValue(f"{path} has the unit of its stage", help="remove `units`, or set `scale`")
    return read


def _of_file(path: str, metres: float | None) -> Mesh:
    """Return the triangles of a file, in metres. Raises ImpossibleValue if it is broken."""
    import trimesh

    try:
        check_mesh_file(resolve_display_path(path))
        loaded: Any = trimesh.load(resolve_display_path(path), force="mesh", process=False, skip_materials=True)
        if metres is not None:
            loaded.apply_scale(metres)
        elif path.lower().endswith(".dae"):  # this format declares its unit; others use metres or none
            loaded.apply_scale(trimesh.units.unit_conversion(loaded.units, "m"))
        if max(len(loaded.vertices), 3 * len(loaded.faces)) > POINTS.most:
            raise POINTS.exceeded()
        return _checked_mesh(loaded)
    except WmsError as error:
        raise ImpossibleValue(f"{path} {error.diagnostics[0].message}", help=error.diagnostics[0].help) from None
    except Exception as error:  # noqa: BLE001  a parser of files of others can fail in any way
        raise ImpossibleValue(f"{path} is broken: {str(error)[:200] or type(error).__name__}") from None


def _checked_mesh(loaded: Any) -> Mesh:
    """Return the mesh that trimesh loaded. Raises ValueError if it is invalid."""
    import numpy as np

    points, faces = np.asarray(loaded.vertices, float), np.asarray(loaded.faces)
    if not len(faces):
        raise ValueError("it has no faces")
    if not np.isfinite(points).all():
        raise ValueError("a point of it is not finite")
    if faces.ndim != 2 or faces.shape[1] != 3 or faces.min() < 0 or faces.max() >= len(points):
        raise ValueError("a face of it has a corner that is no point of it")
    inside_out = loaded.volume < 0
    st = getattr(loaded.visual, "uv", None)
    st = None if st is None else np.asarray(st, float)[:, :2]
    return Mesh(points, faces[:, :: -1 if inside_out else 1], st)


def _hull(path: str, points: NDArray[np.float64]) -> tuple[NDArray[np.float64], float]:
    """Return corners (n, 3) and volume (m³) of the convex hull; for flat meshes, all points and 0."""
    import numpy as np
    import trimesh

    spread = np.linalg.svd(points - points.mean(axis=0), compute_uv=False)
    if len(spread) < 3 or not spread[-1] > 1e-9 * spread[0]:
        return points, 0.0
    try:
        hull = trimesh.convex.convex_hull(points)
    except Exception as error:  # noqa: BLE001  Qhull's own exception, of what is too nearly flat
        raise ImpossibleValue(f"{path} is broken: {str(error).partition(chr(10))[0]}") from None
    return np.asarray(hull.vertices, float), float(hull.volume)
