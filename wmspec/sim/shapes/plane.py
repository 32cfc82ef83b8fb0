"""A plane: the top of a slab, on which things stand."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from wmspec.core.space import UP, Pose, Vector
from wmspec.sim.shapes.box import Box, around, cube
from wmspec.sim.shapes.shape import Flat, Gprim, Prim, Shape, Tensor

if TYPE_CHECKING:
    from wmspec.sim.shapes.facets import Facets

SLAB = 0.1
"""How thick (m) the slab below a plane is."""

ENDLESS = (100.0, 1.0)
"""Width and thickness (m) of the slab that stands for USD's infinite plane."""


@dataclass(frozen=True)
class Plane(Shape):
    """Of the edges `x` and `y` (m), at z = 0, with a slab below it. On a stage it is a box."""

    x: float
    y: float

    lengths = frozenset({1, 2})
    prims = ("Plane",)

    @classmethod
    def from_words(cls, words: Mapping[str, Any]) -> Shape:
        """Its `size` is its two edges, or both of them."""
        size = words["size"]
        return cls(*size) if isinstance(size, tuple) else cls(size, size)

    @property
    def words(self) -> Mapping[str, Any]:
        """Its two edges."""
        return {"size": (self.x, self.y)}

    @property
    def volume(self) -> float:
        """The slab's."""
        return self.x * self.y * SLAB

    @property
    def center(self) -> Vector:
        """The slab's middle."""
        return (0.0, 0.0, -SLAB / 2)

    @property
    def tensor(self) -> Tensor:
        """The slab's."""
        return self._slab.tensor

    def reach(self, direction: Vector) -> float:
        """To a corner of the plane, or of the slab below it."""
        return (abs(direction[0]) * self.x + abs(direction[1]) * self.y) / 2 + max(0.0, -direction[2] * SLAB)

    @property
    def flats(self) -> tuple[Flat, ...]:
        """The plane first, on which things rest."""
        x, y = self.x / 2, self.y / 2
        return ((UP, 0.0), ((0.0, 0.0, -1.0), SLAB), *around(x, y), ((1.0, 0.0, 0.0), x))

    def facets(self) -> Facets:
        """The slab's."""
        from wmspec.sim.shapes.facets import moved

        return moved(self._slab.facets(), self.center)

    def pieces(self) -> tuple[tuple[Shape, Pose], ...]:
        """The slab."""
        return ((self._slab, Pose(self.center)),)

    def prim(self) -> Gprim:
        """A cube below it, which engines take better than an infinite plane."""
        return cube((self.x, self.y, SLAB), self.center)

    @classmethod
    def read(cls, _prim: Prim) -> tuple[Shape, float]:
        """USD's plane is infinite: the top of a big box stands for it."""
        width, thickness = ENDLESS
        return Box((width / 2, width / 2, thickness / 2)), -thickness / 2

    @property
    def _slab(self) -> Box:
        return Box((self.x / 2, self.y / 2, SLAB / 2))
