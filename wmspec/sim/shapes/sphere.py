"""A sphere around the origin."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from wmspec.core.space import Vector
from wmspec.sim.shapes.shape import Gprim, Prim, Shape, Tensor, across_and_up

if TYPE_CHECKING:
    from wmspec.sim.shapes.facets import Facets
    from wmspec.sim.shapes.shape import Array


@dataclass(frozen=True)
class Sphere(Shape):
    """All that is nearer than `radius` (m)."""

    radius: float

    parameters = frozenset({"size", "radius"})
    prims = ("Sphere",)
    symmetry = "ball"

    @classmethod
    def from_words(cls, words: Mapping[str, Any]) -> Shape:
        """Its `size` is its diameter."""
        return cls(across_and_up(words)[0] / 2)

    @property
    def volume(self) -> float:
        """That of any table."""
        return 4 / 3 * math.pi * self.radius**3

    @property
    def tensor(self) -> Tensor:
        """Meriam and Kraige, Engineering Mechanics: Dynamics, table D/4."""
        moment = 0.4 * self.radius**2
        return ((moment, 0.0, 0.0), (0.0, moment, 0.0), (0.0, 0.0, moment))

    def reach(self, direction: Vector) -> float:
        """As far every way."""
        return math.hypot(*direction) * self.radius

    def facets(self) -> Facets:
        """Rings of a globe."""
        from wmspec.sim.shapes.facets import rounded

        return rounded(self.radius, 0.0)

    def unwrapped(self, facets: Facets, every: Array) -> Array:
        """Wound once around, and along a meridian."""
        from wmspec.sim.shapes.texcoords import wound

        return wound(facets, self.radius, math.pi * self.radius, every)

    @property
    def primitive(self) -> tuple[str, tuple[float, ...]]:
        """All engines have it."""
        return "sphere", (float(self.radius),)

    def depth_at(self, point: Array) -> tuple[float, Array]:
        """Below the ball."""
        from wmspec.sim.shapes.sides import round_

        return round_(self.radius, point)

    def prim(self) -> Gprim:
        """USD's own."""
        return Gprim("Sphere", (("radius", "double", self.radius, False),), (self.radius,) * 3)

    @classmethod
    def read(cls, prim: Prim) -> tuple[Shape, float]:
        """Scaled equally along all axes."""
        return cls(prim.positive("radius", 1.0) * prim.uniform()), 0.0
