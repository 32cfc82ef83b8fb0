"""Wedges: half of a box, with the top sloping from left to right."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from wmspec.core.space import Vector, unit
from wmspec.sim.shapes.box import side_faces
from wmspec.sim.shapes.polygons import Polygons
from wmspec.sim.shapes.rounded import box_edges
from wmspec.sim.shapes.shape import Flat, Shape, Tensor

if TYPE_CHECKING:
    from wmspec.sim.shapes.facets import Facets


@dataclass(frozen=True)
class Wedge(Shape):
    """The right prism in a box of these edges (m), with its top edge at -x; a mesh on a stage."""

    x: float
    y: float
    z: float

    lengths = frozenset({1, 3})

    @classmethod
    def from_words(cls, words: Mapping[str, Any]) -> Shape:
        """`size` is the three edges of the bounding box, or one for all."""
        return cls(*box_edges(words))

    @property
    def words(self) -> Mapping[str, Any]:
        """The three edges."""
        return {"size": (self.x, self.y, self.z)}

    @property
    def volume(self) -> float:
        """Half a box."""
        return self.x * self.y * self.z / 2

    @property
    def center(self) -> Vector:
        """A third of the way from the upright face and from the base."""
        return (-self.x / 6, 0.0, -self.z / 6)

    @property
    def tensor(self) -> Tensor:
        """For a right triangle with legs a and b, the mean of x² is a²/18 about the centroid, and of xy -ab/36."""
        x, y, z, xz = self.x**2 / 18, self.y**2 / 12, self.z**2 / 18, self.x * self.z / 36
        return ((y + z, 0.0, xz), (0.0, x + z, 0.0), (xz, 0.0, x + y))

    def reach(self, direction: Vector) -> float:
        """Maximum over its three edges along y: two at the base, one on top at -x."""
        x, z = direction[0] * self.x, direction[2] * self.z
        return (max(abs(x) - z, z - x) + abs(direction[1]) * self.y) / 2

    @property
    def flat_faces(self) -> tuple[Flat, ...]:
        """The slope first."""
        x, y, z = self.x / 2, self.y / 2, self.z / 2
        return ((unit((self.z, 0.0, self.x)), 0.0), ((0.0, 0.0, -1.0), z), *side_faces(x, y))

    def facets(self) -> Facets:
        """Five faces, the image projected from above."""
        import numpy as np

        from wmspec.sim.shapes.facets import smooth

        return smooth(np.array(self.prim().points), self.prim().triangles)

    def prim(self) -> Polygons:
        """A mesh of six points."""
        x, y, z = self.x / 2, self.y / 2, self.z / 2
        points = ((-x, -y, -z), (x, -y, -z), (x, y, -z), (-x, y, -z), (-x, -y, z), (-x, y, z))
        return Polygons(points, ((0, 3, 2, 1), (0, 4, 5, 3), (1, 2, 5, 4), (0, 1, 4), (3, 5, 2)))
