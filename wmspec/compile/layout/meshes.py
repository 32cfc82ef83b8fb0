"""Meshes from files: their triangles, in metres about their own origin, and the convex hull that rests and weighs."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import lru_cache
from typing import TYPE_CHECKING, Any

from wmspec.core.diagnostics import ImpossibleValue, WmsError
from wmspec.core.limits import POINTS
from wmspec.core.space import Vector
from wmspec.lang.check.tables.vocabulary import FILES, MOST_LENGTH, STAGES
from wmspec.lang.importers.mesh_files import harmless
from wmspec.lang.importers.prim_names import parted
from wmspec.lang.parse.files import located
from wmspec.sim.shapes import Mesh

if TYPE_CHECKING:  # most specs have no meshes, and checking those should not wait for numpy
    import numpy as np
    from numpy.typing import NDArray


@dataclass(frozen=True, eq=False)
class FileMesh(Mesh):
    """The mesh of a file, and how it is touched: within `radius` (m) of the hull of the points `touched` (n, 3).

    These are the corners of its own hull, or of the upright box around it, or the middle of a ball around it. `room`
    (m³) is the volume of its own hull, 0 if it is flat.
    """

    touched: NDArray[np.float64] = field(kw_only=True)
    room: float = field(kw_only=True)
    radius: float = field(kw_only=True)

    @property
    def outline(self) -> NDArray[np.float64]:
        """What is touched."""
        return self.touched

    @property
    def volume(self) -> float:
        """The hull's, whatever is touched."""
        return self.room

    def reach(self, direction: Vector) -> float:
        """As far as what is touched of it."""
        return super().reach(direction) + self.radius * math.hypot(*direction)

    def bounds(self, turn: NDArray[np.float64]) -> NDArray[np.float64]:
        """Of what is touched of it."""
        import numpy as np

        return np.asarray(super().bounds(turn) + np.array([[-self.radius], [self.radius]]))


def load(path: str, scale: float | Vector, collision: str, solid: bool) -> FileMesh:
    """The mesh in a file, `scale` times as large, along all of its axes or each, touched as its `collision` says.

    A file is read once.

    Raises:
        ImpossibleValue: if the file is missing, of another kind, broken, or has no volume though it is `solid`.
    """
    name, prim = parted(path)
    file = located(name)
    if file.suffix.lower() not in (STAGES if prim else FILES["file"]):
        raise ImpossibleValue(f"{file.name} is no mesh that can be read", help=f"use one of {', '.join(FILES['file'])}")
    try:
        status = file.stat()
    except OSError as error:
        raise ImpossibleValue(f"{name} cannot be read: {error.strerror}") from None
    import numpy as np

    with np.errstate(all="ignore"):  # what comes of extreme numbers is told by us
        made = _load(path, status.st_mtime_ns, status.st_size, scale, collision)
    if solid and made.volume <= 0 and collision != "surface":
        raise ImpossibleValue(f"{path} has no volume", help="use a mesh that is not flat")
    return made


@lru_cache(maxsize=256)
def _load(path: str, _changed: int, _size: int, scale: float | Vector, collision: str) -> FileMesh:
    import numpy as np

    stretch = np.broadcast_to(np.asarray(scale, float), 3)
    whole = _of_stage(path) if parted(path)[1] else _of_file(path)
    points, faces = whole.points * stretch, whole.faces[:, :: -1 if np.sign(stretch).prod() < 0 else 1]
    low, high = points.min(axis=0), points.max(axis=0)
    if not (size := float((high - low).max())) <= MOST_LENGTH:
        what = f"{size / 1000:g} km large with this scale; the most is {MOST_LENGTH / 1000:g} km"
        raise ImpossibleValue(f"{path} is {what}")
    hull, volume = _hull(path, points)
    touched, radius = hull, 0.0
    if collision == "bounds":
        touched = np.array(np.meshgrid(*zip(low, high, strict=True))).reshape(3, -1).T
    if collision == "ball":
        touched = (low + high)[None] / 2
        radius = float(np.linalg.norm(points - touched, axis=1).max())
    return FileMesh(points, np.asarray(faces, np.int32), whole.st, touched=touched, room=volume, radius=radius)


def _of_stage(path: str) -> Mesh:
    """The triangles of a mesh in a USD file. Raises ImpossibleValue if it is broken."""
    from wmspec.lang.importers.usd_file import mesh

    name, prim = parted(path)
    read = mesh(located(name), None, name, prim)
    if isinstance(read, tuple):
        raise ImpossibleValue("; ".join(f"{mistake.place}: {mistake.message}" for mistake in read))
    return read


def _of_file(path: str) -> Mesh:
    """The triangles of a file. Raises ImpossibleValue if it is broken."""
    import trimesh

    try:
        harmless(located(path))
        loaded: Any = trimesh.load(located(path), force="mesh", process=False, skip_materials=True)
        if path.lower().endswith(".dae"):  # which says its unit; the others mean metres, or nothing
            loaded.apply_scale(trimesh.units.unit_conversion(loaded.units, "m"))
        if max(len(loaded.vertices), 3 * len(loaded.faces)) > POINTS.most:
            raise POINTS.exceeded()
        return _checked(loaded)
    except WmsError as error:
        raise ImpossibleValue(f"{path} {error.diagnostics[0].message}", help=error.diagnostics[0].help) from None
    except Exception as error:  # noqa: BLE001  a parser of files of others can fail in any way
        raise ImpossibleValue(f"{path} is broken: {str(error)[:200] or type(error).__name__}") from None


def _checked(loaded: Any) -> Mesh:
    """What trimesh read. Raises ValueError for what is no mesh."""
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
    """The corners (n, 3) and the volume (m³) of the convex hull; of what is flat, all points and 0."""
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
