"""A box along its own axes, and the cube, whose edges are alike."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

from wmspec.core.space import Vector, times
from wmspec.sim.shapes.rounded import RoundedBox, edges
from wmspec.sim.shapes.shape import AXES, Flat, Gprim, Prim, Shape, Tensor

if TYPE_CHECKING:
    from wmspec.sim.shapes.facets import Facets


@dataclass(frozen=True)
class Box(Shape):
    """As far as `half` (3,) m from the origin along its axes."""

    half: Vector

    lengths = frozenset({1, 3})
    properties = RoundedBox.properties
    prims: ClassVar[tuple[str, ...]] = ("Cube",)

    @classmethod
    def from_words(cls, words: Mapping[str, Any]) -> Shape:
        """Its `size` is its three edges, or all of them."""
        if "round" in words:
            return RoundedBox.from_words(words)
        x, y, z = edges(words)
        return Box((x / 2, y / 2, z / 2))

    @property
    def words(self) -> Mapping[str, Any]:
        """Its three edges."""
        return {"size": tuple(2 * half for half in self.half)}

    @property
    def volume(self) -> float:
        """That of any table."""
        x, y, z = self.half
        return 8.0 * (x * y * z)

    @property
    def tensor(self) -> Tensor:
        """Meriam and Kraige, Engineering Mechanics: Dynamics, table D/4."""
        x, y, z = (h * h / 3 for h in self.half)
        return ((y + z, 0.0, 0.0), (0.0, x + z, 0.0), (0.0, 0.0, x + y))

    def reach(self, direction: Vector) -> float:
        """To its corner."""
        x, y, z = self.half
        return abs(direction[0]) * x + abs(direction[1]) * y + abs(direction[2]) * z

    @property
    def flats(self) -> tuple[Flat, ...]:
        """The upper one first, on which things rest."""
        x, y, z = self.half
        return ((AXES[2], z), ((0.0, 0.0, -1.0), z), *around(x, y), (AXES[0], x))

    def facets(self) -> Facets:
        """Six sides, each with the whole image."""
        import numpy as np

        from wmspec.sim.shapes.facets import join, side

        half = np.array(self.half, np.float64)
        return join([side(half, axis, sign) for axis in range(3) for sign in (-1.0, 1.0)])

    @property
    def primitive(self) -> tuple[str, tuple[float, ...]]:
        """All engines have it."""
        x, y, z = self.half
        return "box", (float(x), float(y), float(z))

    def prim(self) -> Gprim:
        """USD's cube, scaled."""
        return cube(times(2.0, self.half))

    @classmethod
    def read(cls, prim: Prim) -> tuple[Shape, float]:
        """Scaled in any way."""
        size = prim.positive("size", 2.0) / 2
        x, y, z = (abs(scale) * size for scale in prim.scale)
        return Box((x, y, z)), 0.0


class Cube(Box):
    """The word for a box of one edge; the shape is a Box."""

    lengths = frozenset({1})
    prims = ()


def around(x: float, y: float) -> tuple[Flat, ...]:
    """The sides of a box that look to ±y and to -x, so far (m) from the origin."""
    return (((0.0, 1.0, 0.0), y), ((0.0, -1.0, 0.0), y), ((-1.0, 0.0, 0.0), x))


def cube(scale: Vector, offset: Vector = (0.0, 0.0, 0.0)) -> Gprim:
    """USD's cube of 1 m, scaled and moved."""
    return Gprim("Cube", (("size", "double", 1.0, False),), (0.5, 0.5, 0.5), offset, scale)
