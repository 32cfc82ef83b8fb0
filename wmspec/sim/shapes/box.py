"""Boxes along their own axes, and cubes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

from wmspec.core.space import Vector, scale
from wmspec.sim.shapes.rounded import RoundedBox, box_edges
from wmspec.sim.shapes.shape import AXES, Flat, Gprim, Prim, Shape, Tensor

if TYPE_CHECKING:
    from wmspec.sim.shapes.facets import Facets


@dataclass(frozen=True)
class Box(Shape):
    """A box with half edges `half` (3,) m around the origin."""

    half: Vector

    lengths = frozenset({1, 3})
    properties = RoundedBox.properties
    prims: ClassVar[tuple[str, ...]] = ("Cube",)
    engine_kind = "box"

    @classmethod
    def from_words(cls, words: Mapping[str, Any]) -> Shape:
        """`size` is the three edges, or one length for all."""
        if "round" in words:
            return RoundedBox.from_words(words)
        x, y, z = box_edges(words)
        return Box((x / 2, y / 2, z / 2))

    @property
    def words(self) -> Mapping[str, Any]:
        """The three edges."""
        return {"size": tuple(2 * half for half in self.half)}

    @property
    def volume(self) -> float:
        """8 half_x half_y half_z."""
        x, y, z = self.half
        return 8.0 * (x * y * z)

    @property
    def tensor(self) -> Tensor:
        """Meriam and Kraige, Engineering Mechanics: Dynamics, table D/4."""
        x, y, z = (h * h / 3 for h in self.half)
        return ((y + z, 0.0, 0.0), (0.0, x + z, 0.0), (0.0, 0.0, x + y))

    def reach(self, direction: Vector) -> float:
        """Distance of the extreme corner."""
        x, y, z = self.half
        return abs(direction[0]) * x + abs(direction[1]) * y + abs(direction[2]) * z

    @property
    def flat_faces(self) -> tuple[Flat, ...]:
        """The six faces, top first."""
        x, y, z = self.half
        return ((AXES[2], z), ((0.0, 0.0, -1.0), z), *side_faces(x, y), (AXES[0], x))

    def facets(self) -> Facets:
        """Six faces, each with the whole image."""
        import numpy as np

        from wmspec.sim.shapes.facets import join, side

        half = np.array(self.half, np.float64)
        return join([side(half, axis, sign) for axis in range(3) for sign in (-1.0, 1.0)])

    def prim(self) -> Gprim:
        """A scaled USD cube."""
        return cube_prim(scale(2.0, self.half))

    @classmethod
    def read(cls, prim: Prim) -> tuple[Shape, float]:
        """Any scale is valid."""
        size = prim.positive("size", 2.0) / 2
        x, y, z = (abs(scale) * size for scale in prim.scale)
        return Box((x, y, z)), 0.0


class Cube(Box):
    """The word for a box with equal edges; the shape is a Box."""

    lengths = frozenset({1})
    prims = ()


def side_faces(x: float, y: float) -> tuple[Flat, ...]:
    """Return the faces of a box towards ±y and -x at these distances (m)."""
    return (((0.0, 1.0, 0.0), y), ((0.0, -1.0, 0.0), y), ((-1.0, 0.0, 0.0), x))


def cube_prim(scale: Vector, offset: Vector = (0.0, 0.0, 0.0)) -> Gprim:
    """Return USD's cube of 1 m, scaled and translated."""
    return Gprim("Cube", (("size", "double", 1.0, False),), (0.5, 0.5, 0.5), offset, scale)
