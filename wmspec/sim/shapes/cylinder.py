"""A cylinder along z, centred."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from wmspec.core.space import UP, Vector
from wmspec.sim.shapes.shape import Gprim, Prim, Shape, Tensor, across_and_up, round_gprim

if TYPE_CHECKING:
    from wmspec.sim.shapes.facets import Facets
    from wmspec.sim.shapes.shape import Array


@dataclass(frozen=True)
class Cylinder(Shape):
    """As far as `radius` (m) from z, its caps at ±`height` / 2."""

    radius: float
    height: float

    parameters = frozenset({"size", "radius", "height"})
    prims = ("Cylinder", "Cylinder_1")
    symmetry = "axis"
    rim = True

    @classmethod
    def from_words(cls, words: Mapping[str, Any]) -> Shape:
        """Its `size` is its diameter and its height."""
        across, up = across_and_up(words, tall=True)
        return cls(across / 2, up)

    @property
    def volume(self) -> float:
        """That of any table."""
        return math.pi * self.radius**2 * self.height

    @property
    def tensor(self) -> Tensor:
        """Meriam and Kraige, Engineering Mechanics: Dynamics, table D/4."""
        across = self.radius**2 / 4 + self.height**2 / 12
        return ((across, 0.0, 0.0), (0.0, across, 0.0), (0.0, 0.0, self.radius**2 / 2))

    def reach(self, direction: Vector) -> float:
        """To its rim."""
        return math.hypot(direction[0], direction[1]) * self.radius + abs(direction[2]) * self.height / 2

    def facets(self) -> Facets:
        """A side and two caps."""
        from wmspec.sim.shapes.facets import Row, disc, join, lathe

        r, h = float(self.radius), float(self.height)
        side: list[Row] = [(r, -h / 2, 1, 0, 0), (r, h / 2, 1, 0, 1)]
        return join([lathe(side), disc(r, -h / 2, -1.0), disc(r, h / 2, 1.0)])

    def unwrapped(self, facets: Facets, every: Array) -> Array:
        """Wound around the side, flat on the caps."""
        from wmspec.sim.shapes.texcoords import capped

        return capped(facets, self.radius, self.height, every)

    @property
    def primitive(self) -> tuple[str, tuple[float, ...]]:
        """All engines have it."""
        return "cylinder", (float(self.radius), float(self.height))

    def depths_at(self, point: Array) -> list[tuple[float, Array]]:
        """Its caps and the tube."""
        from wmspec.sim.shapes.sides import below, round_

        caps = below((((0.0, 0.0, -1.0), self.height / 2), (UP, self.height / 2)), point)
        return [*caps, round_(self.radius, point * [1.0, 1.0, 0.0])]

    def prim(self) -> Gprim:
        """USD's own."""
        return round_gprim("Cylinder", self.radius, self.height, self.height / 2)

    @classmethod
    def read(cls, prim: Prim) -> tuple[Shape, float]:
        """Scaled equally across its axis."""
        across, along = prim.around()
        return cls(prim.radius(1.0) * across, prim.positive("height", 2.0) * along), 0.0
