"""A capsule: a cylinder along z with half balls as its ends."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from wmspec.core.space import Vector
from wmspec.sim.shapes.shape import Gprim, Prim, Shape, Tensor, UnfitError, across_and_up, round_gprim

if TYPE_CHECKING:
    from wmspec.sim.shapes.facets import Facets
    from wmspec.sim.shapes.shape import Array


@dataclass(frozen=True)
class Capsule(Shape):
    """All that is nearer than `radius` to a straight line along z, which is `height` long (m)."""

    radius: float
    height: float

    parameters = frozenset({"size", "radius", "height"})
    prims = ("Capsule", "Capsule_1")
    symmetry = "axis"

    @classmethod
    def from_words(cls, words: Mapping[str, Any]) -> Shape:
        """Its `size` and its `height` are the whole height; with a `size` alone it is half as wide."""
        across, up = across_and_up(words, slim=0.5, tall=True)
        if up <= across:
            raise UnfitError("is not higher than it is wide")
        return cls(across / 2, up - across)

    @property
    def words(self) -> Mapping[str, Any]:
        """Its whole height."""
        return {"radius": self.radius, "height": self.height + 2 * self.radius}

    @property
    def volume(self) -> float:
        """A cylinder and a ball."""
        return math.pi * self.radius**2 * self.height + 4 / 3 * math.pi * self.radius**3

    @property
    def tensor(self) -> Tensor:
        """A cylinder and two half balls, moved out by Huygens and Steiner."""
        r, h = self.radius, self.height
        straight = math.pi * r**2 * h
        ends = 4 / 3 * math.pi * r**3
        m, n = straight / (straight + ends), ends / (straight + ends)
        across = m * (h**2 / 12 + r**2 / 4) + n * (0.4 * r**2 + h**2 / 4 + 3 * h * r / 8)
        along = m * r**2 / 2 + n * 0.4 * r**2
        return ((across, 0.0, 0.0), (0.0, across, 0.0), (0.0, 0.0, along))

    def reach(self, direction: Vector) -> float:
        """That of its line, and of a ball."""
        return math.hypot(*direction) * self.radius + abs(direction[2]) * self.height / 2

    def facets(self) -> Facets:
        """Rings of a globe that is pulled apart at its equator."""
        from wmspec.sim.shapes.facets import rounded

        return rounded(self.radius, self.height)

    def unwrapped(self, facets: Facets, every: Array) -> Array:
        """Wound once around, and along a meridian."""
        from wmspec.sim.shapes.texcoords import wound

        return wound(facets, self.radius, math.pi * self.radius + self.height, every)

    @property
    def primitive(self) -> tuple[str, tuple[float, ...]]:
        """All engines have it."""
        return "capsule", (float(self.radius), float(self.height))

    def depth_at(self, point: Array) -> tuple[float, Array]:
        """Below the ball around the nearest point of its line."""
        from wmspec.sim.shapes.sides import round_

        nearest = min(max(float(point[2]), -self.height / 2), self.height / 2)
        return round_(self.radius, point - [0.0, 0.0, nearest])

    def prim(self) -> Gprim:
        """USD's own."""
        return round_gprim("Capsule", self.radius, self.height, self.radius + self.height / 2)

    @classmethod
    def read(cls, prim: Prim) -> tuple[Shape, float]:
        """Scaled equally along all axes."""
        factor = prim.uniform()
        height = prim.least("height", 1.0)
        return cls(prim.radius(0.5) * factor, height * factor), 0.0
