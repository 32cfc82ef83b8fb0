"""Spheres around the origin."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from wmspec.core.space import Vector
from wmspec.sim.shapes.shape import Gprim, Prim, Shape, Tensor, width_and_height

if TYPE_CHECKING:
    from wmspec.sim.shapes.facets import Facets
    from wmspec.sim.shapes.shape import Array


@dataclass(frozen=True)
class Sphere(Shape):
    """All points within `radius` (m)."""

    radius: float

    parameters = frozenset({"size", "radius"})
    prims = ("Sphere",)
    engine_kind = "sphere"
    symmetry = "ball"

    @classmethod
    def from_words(cls, words: Mapping[str, Any]) -> Shape:
        """`size` is the diameter."""
        return cls(width_and_height(words)[0] / 2)

    @property
    def volume(self) -> float:
        """4/3 π r³."""
        return 4 / 3 * math.pi * self.radius**3

    @property
    def tensor(self) -> Tensor:
        """Meriam and Kraige, Engineering Mechanics: Dynamics, table D/4."""
        moment = 0.4 * self.radius**2
        return ((moment, 0.0, 0.0), (0.0, moment, 0.0), (0.0, 0.0, moment))

    def reach(self, direction: Vector) -> float:
        """The radius."""
        return math.hypot(*direction) * self.radius

    def facets(self) -> Facets:
        """Rings of a sphere."""
        from wmspec.sim.shapes.facets import rounded

        return rounded(self.radius, 0.0)

    def unwrapped(self, facets: Facets, every: Array) -> Array:
        """Wrapped once around, and along a meridian."""
        from wmspec.sim.shapes.texcoords import wrapped_texcoords

        return wrapped_texcoords(facets, self.radius, math.pi * self.radius, every)

    def depth_at(self, point: Array) -> tuple[float, Array]:
        """Depth below the sphere."""
        from wmspec.sim.shapes.sides import round_depth

        return round_depth(self.radius, point)

    def prim(self) -> Gprim:
        """USD's sphere."""
        return Gprim("Sphere", (("radius", "double", self.radius, False),), (self.radius,) * 3)

    @classmethod
    def read(cls, prim: Prim) -> tuple[Shape, float]:
        """The scale must be uniform."""
        return cls(prim.positive("radius", 1.0) * prim.uniform()), 0.0
