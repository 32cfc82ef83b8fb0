"""Triangle meshes, which collide as their convex hull."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, fields
from functools import cached_property
from typing import TYPE_CHECKING, Any

from wmspec.core.space import IDENTITY, Pose, Vector
from wmspec.sim.shapes.polygons import Polygons
from wmspec.sim.shapes.shape import Shape, Tensor

if TYPE_CHECKING:  # most specs have no meshes and can be checked without numpy
    import numpy as np
    from numpy.typing import ArrayLike, NDArray

    from wmspec.sim.shapes.facets import Facets
    from wmspec.sim.shapes.shape import Array


def hulls(parts: Iterable[ArrayLike]) -> tuple[tuple[Shape, Pose], ...]:
    """Meshes that collide as the convex hulls of sets of points (n, 3), each at the origin."""
    import numpy as np

    none: NDArray[np.int32] = np.empty((0, 3), np.int32)
    return tuple((Mesh(np.asarray(points), none), IDENTITY) for points in parts)


@dataclass(frozen=True, eq=False)
class Mesh(Shape):
    """Triangles: `points` (n, 3), `faces` (m, 3) vertex indices, texture coordinates `st` (n, 2) or None.

    Mass properties and extent are those of the convex hull.
    """

    points: Array
    faces: NDArray[np.int32]
    st: Array | None = None

    convex = False

    def __eq__(self, other: object) -> bool:
        return type(other) is type(self) and self._content == other._content

    def __hash__(self) -> int:
        return hash(self._content)

    def __getstate__(self) -> dict[str, Any]:
        """Exclude cached values: equal meshes pickle to equal bytes."""
        return {field.name: getattr(self, field.name) for field in fields(self)}

    @cached_property
    def _content(self) -> tuple[bytes, ...]:
        import numpy as np

        arrays = (self.points, self.faces) if self.st is None else (self.points, self.faces, self.st)
        return tuple(np.ascontiguousarray(array).tobytes() for array in arrays)

    @property
    def outline(self) -> Array:
        """The points (n, 3) of the collision hull."""
        return self.points

    @property
    def solid(self) -> Any:
        """The collision hull as a `trimesh.Trimesh`. Raises WmsError if it is flat."""
        from wmspec.sim.shapes.hull import hull

        return hull(self.outline)

    @property
    def volume(self) -> float:
        """Of the hull."""
        return float(self.solid.volume)

    @property
    def center(self) -> Vector:
        """Of the hull."""
        x, y, z = self.solid.center_mass.tolist()
        return (x, y, z)

    @property
    def tensor(self) -> Tensor:
        """Of the hull."""
        x, y, z = (self.solid.moment_inertia / float(self.solid.mass)).tolist()
        return (tuple(x), tuple(y), tuple(z))

    def reach(self, direction: Vector) -> float:
        """Distance of the extreme point."""
        return float((self.outline @ direction).max())

    @property
    def sizes(self) -> tuple[float, ...]:
        """The size of the mesh."""
        import numpy as np

        return (float(np.ptp(self.points, axis=0).max()) if len(self.points) else 0.0,)

    @property
    def half_extent(self) -> Vector:
        """Distance of the extreme points along the axes."""
        x, y, z = abs(self.points).max(axis=0).tolist()
        return (x, y, z)

    def bounds(self, turn: Array) -> Array:
        """Of its points."""
        import numpy as np

        points = np.asarray(self.outline, float) @ turn.T
        return np.stack([points.min(axis=0), points.max(axis=0)])

    def facets(self) -> Facets:
        """Its own triangles."""
        from wmspec.sim.shapes.facets import smooth

        return smooth(self.points, self.faces, self.st)

    def triangles(self) -> tuple[Array, NDArray[np.int32]]:
        """As given."""
        return self.points, self.faces

    def unwrapped(self, facets: Facets, every: Array) -> Array:
        """By its own texture coordinates."""
        repeated: Array = facets.st * every
        return super().unwrapped(facets, every) if self.st is None else repeated

    def corners(self) -> Array:
        """Of the hull."""
        from wmspec.sim.shapes.hull import limit_corners

        return limit_corners(self.solid)

    def depths_at(self, point: Array) -> list[tuple[float, Array]]:
        """Of the hull."""
        from wmspec.sim.shapes.sides import hull_depths

        return hull_depths(self.outline, point)

    def prim(self) -> Polygons:
        """Its triangles."""
        return self._polygons

    @cached_property
    def _polygons(self) -> Polygons:
        st = None if self.st is None else tuple((s, t) for s, t in self.st.tolist())
        points, faces = self.points.tolist(), self.faces.tolist()
        return Polygons(tuple((x, y, z) for x, y, z in points), tuple((a, b, c) for a, b, c in faces), st)
