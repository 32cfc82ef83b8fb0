"""A wedge: half of a box, whose top falls from the left to the right."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from wmspec.core.space import Vector, unit
from wmspec.sim.shapes.box import around
from wmspec.sim.shapes.polygons import Polygons
from wmspec.sim.shapes.rounded import edges
from wmspec.sim.shapes.shape import Flat, Shape, Tensor

if TYPE_CHECKING:
    from wmspec.sim.shapes.facets import Facets


@dataclass(frozen=True)
class Wedge(Shape):
    """The right prism in the box of these edges (m) whose top edge is at -x. On a stage it is a mesh."""

    x: float
    y: float
    z: float

    lengths = frozenset({1, 3})

    @classmethod
    def from_words(cls, words: Mapping[str, Any]) -> Shape:
        """Its `size` is the three edges of the box around it, or all of them."""
        return cls(*edges(words))

    @property
    def words(self) -> Mapping[str, Any]:
        """Its three edges."""
        return {"size": (self.x, self.y, self.z)}

    @property
    def volume(self) -> float:
        """Half a box."""
        return self.x * self.y * self.z / 2

    @property
    def center(self) -> Vector:
        """A third of the way from the upright side and from the foot."""
        return (-self.x / 6, 0.0, -self.z / 6)

    @property
    def tensor(self) -> Tensor:
        """Of a right triangle with legs a and b, the mean of x² is a²/18 about its centroid, and of xy -ab/36."""
        x, y, z, xz = self.x**2 / 18, self.y**2 / 12, self.z**2 / 18, self.x * self.z / 36
        return ((y + z, 0.0, xz), (0.0, x + z, 0.0), (xz, 0.0, x + y))

    def reach(self, direction: Vector) -> float:
        """Of its three corners, or rather edges along y: the two at its foot and the upper one at -x."""
        x, z = direction[0] * self.x, direction[2] * self.z
        return (max(abs(x) - z, z - x) + abs(direction[1]) * self.y) / 2

    @property
    def flats(self) -> tuple[Flat, ...]:
        """The slope first, on which things rest."""
        x, y, z = self.x / 2, self.y / 2, self.z / 2
        return ((unit((self.z, 0.0, self.x)), 0.0), ((0.0, 0.0, -1.0), z), *around(x, y))

    def facets(self) -> Facets:
        """Five sides, the image on them seen from above."""
        import numpy as np

        from wmspec.sim.shapes.facets import smooth

        return smooth(np.array(self.prim().points), self.prim().triangles)

    def prim(self) -> Polygons:
        """A mesh like others: six points say all."""
        x, y, z = self.x / 2, self.y / 2, self.z / 2
        points = ((-x, -y, -z), (x, -y, -z), (x, y, -z), (-x, y, -z), (-x, -y, z), (-x, y, z))
        return Polygons(points, ((0, 3, 2, 1), (0, 4, 5, 3), (1, 2, 5, 4), (0, 1, 4), (3, 5, 2)))
