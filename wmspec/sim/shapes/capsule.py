"""Capsules: a cylinder along z with hemispherical ends."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from wmspec.core.space import Vector
from wmspec.sim.shapes.shape import Gprim, Prim, Shape, Tensor, UnfitError, round_gprim, width_and_height

if TYPE_CHECKING:
    from wmspec.sim.shapes.facets import Facets
    from wmspec.sim.shapes.shape import Array


@dataclass(frozen=True)
class Capsule(Shape):
    """All points within `radius` of a segment along z of length `height` (m)."""

    radius: float
    height: float

    parameters = frozenset({"size", "radius", "height"})
    prims = ("Capsule", "Capsule_1")
    engine_kind = "capsule"
    symmetry = "axis"

    @classmethod
    def from_words(cls, words: Mapping[str, Any]) -> Shape:
        """`size` and `height` are the total height; with `size` alone the width is half of it."""
        across, up = width_and_height(words, slim=0.5, tall=True)
        if up <= across:
            raise UnfitError("is not higher than it is wide")
        return cls(across / 2, up - across)

    @property
    def words(self) -> Mapping[str, Any]:
        """The total height and radius."""
        return {"radius": self.radius, "height": self.height + 2 * self.radius}

    @property
    def volume(self) -> float:
        """Cylinder plus sphere."""
        return math.pi * self.radius**2 * self.height + 4 / 3 * math.pi * self.radius**3

    @property
    def tensor(self) -> Tensor:
        """Cylinder plus two hemispheres, by the parallel axis theorem."""
        r, h = self.radius, self.height
        straight = math.pi * r**2 * h
        ends = 4 / 3 * math.pi * r**3
        m, n = straight / (straight + ends), ends / (straight + ends)
        across = m * (h**2 / 12 + r**2 / 4) + n * (0.4 * r**2 + h**2 / 4 + 3 * h * r / 8)
        along = m * r**2 / 2 + n * 0.4 * r**2
        return ((across, 0.0, 0.0), (0.0, across, 0.0), (0.0, 0.0, along))

    def reach(self, direction: Vector) -> float:
        """Segment plus sphere."""
        return math.hypot(*direction) * self.radius + abs(direction[2]) * self.height / 2

    def facets(self) -> Facets:
        """Rings of a sphere, separated at the equator."""
        from wmspec.sim.shapes.facets import rounded

        return rounded(self.radius, self.height)

    def unwrapped(self, facets: Facets, every: Array) -> Array:
        """Wrapped once around, and along a meridian."""
        from wmspec.sim.shapes.texcoords import wrapped_texcoords

        return wrapped_texcoords(facets, self.radius, math.pi * self.radius + self.height, every)

    def depth_at(self, point: Array) -> tuple[float, Array]:
        """Depth below the sphere around the nearest point of the segment."""
        from wmspec.sim.shapes.sides import round_depth

        nearest = min(max(float(point[2]), -self.height / 2), self.height / 2)
        return round_depth(self.radius, point - [0.0, 0.0, nearest])

    def prim(self) -> Gprim:
        """USD's capsule."""
        return round_gprim("Capsule", self.radius, self.height, self.radius + self.height / 2)

    @classmethod
    def read(cls, prim: Prim) -> tuple[Shape, float]:
        """The scale must be uniform."""
        factor = prim.uniform()
        height = prim.least("height", 1.0)
        return cls(prim.radius(0.5) * factor, height * factor), 0.0
