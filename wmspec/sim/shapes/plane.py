"""Planes: the top of a slab that bodies stand on."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from wmspec.core.space import UP, Pose, Vector
from wmspec.sim.shapes.box import Box, cube_prim, side_faces
from wmspec.sim.shapes.shape import Flat, Gprim, Prim, Shape, Tensor

if TYPE_CHECKING:
    from wmspec.sim.shapes.facets import Facets

SLAB_THICKNESS = 0.1
"""m."""

INFINITE_PLANE_SLAB = (100.0, 1.0)
"""Width and thickness (m) of the slab that replaces USD's infinite plane."""


@dataclass(frozen=True)
class Plane(Shape):
    """A plane with edges `x` and `y` (m) at z = 0 on a slab; a box on a stage."""

    x: float
    y: float

    lengths = frozenset({1, 2})
    prims = ("Plane",)

    @classmethod
    def from_words(cls, words: Mapping[str, Any]) -> Shape:
        """`size` is two edges, or one for both."""
        size = words["size"]
        return cls(*size) if isinstance(size, tuple) else cls(size, size)

    @property
    def words(self) -> Mapping[str, Any]:
        """The two edges."""
        return {"size": (self.x, self.y)}

    @property
    def volume(self) -> float:
        """Of the slab."""
        return self.x * self.y * SLAB_THICKNESS

    @property
    def center(self) -> Vector:
        """Of the slab."""
        return (0.0, 0.0, -SLAB_THICKNESS / 2)

    @property
    def tensor(self) -> Tensor:
        """Of the slab."""
        return self._slab.tensor

    def reach(self, direction: Vector) -> float:
        """Distance of a corner of plane or slab."""
        return (abs(direction[0]) * self.x + abs(direction[1]) * self.y) / 2 + max(0.0, -direction[2] * SLAB_THICKNESS)

    @property
    def flat_faces(self) -> tuple[Flat, ...]:
        """The plane first."""
        x, y = self.x / 2, self.y / 2
        return ((UP, 0.0), ((0.0, 0.0, -1.0), SLAB_THICKNESS), *side_faces(x, y), ((1.0, 0.0, 0.0), x))

    def facets(self) -> Facets:
        """Of the slab."""
        from wmspec.sim.shapes.facets import translated

        return translated(self._slab.facets(), self.center)

    @property
    def pieces(self) -> tuple[tuple[Shape, Pose], ...]:
        """The slab."""
        return ((self._slab, Pose(self.center)),)

    def prim(self) -> Gprim:
        """A cube below it, which engines handle better than an infinite plane."""
        return cube_prim((self.x, self.y, SLAB_THICKNESS), self.center)

    @classmethod
    def read(cls, _prim: Prim) -> tuple[Shape, float]:
        """USD's plane is infinite; a large box replaces it."""
        width, thickness = INFINITE_PLANE_SLAB
        return Box((width / 2, width / 2, thickness / 2)), -thickness / 2

    @property
    def _slab(self) -> Box:
        return Box((self.x / 2, self.y / 2, SLAB_THICKNESS / 2))
