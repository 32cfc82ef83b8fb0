"""Meshes from files: their triangles, in metres about their own origin, and the convex hull that rests and weighs."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING, Any

from wmspec.check.vocabulary import FILES
from wmspec.design.space import Vector
from wmspec.errors import WmsError
from wmspec.parse.load import located

if TYPE_CHECKING:  # most specs have no meshes, and checking those should not wait for numpy
    import numpy as np
    from numpy.typing import NDArray


@dataclass(frozen=True, eq=False)
class Mesh:
    """Triangles: `points`, `faces` of three indices, texture coordinates `st` of each point or None.

    `edges` (m) are those of the upright box around it, `corners` (n, 3) the points of its convex hull, or of that box
    if that is what is touched; `volume` (m³) is the hull's.
    """

    points: tuple[Vector, ...]
    faces: tuple[tuple[int, int, int], ...]
    st: tuple[tuple[float, float], ...] | None
    edges: Vector
    corners: NDArray[np.float64]
    volume: float

    def reach(self, direction: Vector) -> float:
        """The largest component (m) of its corners along a direction."""
        return float((self.corners @ direction).max())


def load(path: str, scale: float | Vector, collision: str) -> Mesh:
    """The mesh in a file, `scale` times as large, along all of its axes or each, touched as its `collision` says.

    A file is read once.

    Raises:
        WmsError: if the file is missing, of another kind, broken, or has no volume.
    """
    file = located(path)
    if file.suffix.lower() not in FILES["file"]:
        raise WmsError(f"{file.name} is no mesh that can be read; use one of {', '.join(FILES['file'])}")
    try:
        found = file.stat()
    except OSError as error:
        raise WmsError(f"{path} cannot be read: {error.strerror}") from None
    return _load(path, found.st_mtime_ns, found.st_size, scale, collision)


@lru_cache(maxsize=256)
def _load(path: str, _changed: int, _size: int, scale: float | Vector, collision: str) -> Mesh:
    import numpy as np
    import trimesh

    try:
        found: Any = trimesh.load(path, force="mesh", process=False, skip_materials=True)
        hull = found.convex_hull
    except Exception as error:  # noqa: BLE001  a parser of files of others can fail in any way
        raise WmsError(f"{path} is broken: {str(error) or type(error).__name__}") from None
    if not len(found.faces) or hull.volume <= 0:
        raise WmsError(f"{path} has no volume; use a mesh that is not flat")
    stretch = np.broadcast_to(np.asarray(scale, float), 3)
    points, faces = np.asarray(found.vertices, float) * stretch, np.asarray(found.faces)
    if (found.volume < 0) != (stretch.prod() < 0):  # inside out, or mirrored
        faces = faces[:, ::-1]
    low, high = points.min(axis=0), points.max(axis=0)
    corners = np.array(np.meshgrid(*zip(low, high, strict=True))).reshape(3, -1).T
    st = getattr(found.visual, "uv", None)
    x, y, z = (high - low).tolist()
    return Mesh(
        tuple((x, y, z) for x, y, z in points.tolist()),
        tuple((a, b, c) for a, b, c in faces.tolist()),
        None if st is None else tuple((s, t) for s, t in np.asarray(st, float)[:, :2].tolist()),
        (x, y, z),
        corners if collision == "bounds" else np.asarray(hull.vertices, float) * stretch,
        float(hull.volume) * abs(float(stretch.prod())),
    )
