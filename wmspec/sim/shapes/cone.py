"""A cone along z, centred on half its height."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from wmspec.core.space import Vector
from wmspec.sim.shapes.shape import Gprim, Prim, Shape, Tensor, across_and_up, round_gprim

if TYPE_CHECKING:
    from wmspec.sim.shapes.facets import Facets
    from wmspec.sim.shapes.shape import Array

SIDES = 48  # of the solid that collides


@dataclass(frozen=True)
class Cone(Shape):
    """A base of a `radius` (m) at -`height` / 2, its apex at +`height` / 2."""

    radius: float
    height: float

    parameters = frozenset({"size", "radius", "height"})
    prims = ("Cone",)
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
        return math.pi * self.radius**2 * self.height / 3

    @property
    def center(self) -> Vector:
        """A quarter of the height above the base."""
        return (0.0, 0.0, -self.height / 4)

    @property
    def tensor(self) -> Tensor:
        """Meriam and Kraige, Engineering Mechanics: Dynamics, table D/4."""
        across = 3 / 20 * self.radius**2 + 3 / 80 * self.height**2
        return ((across, 0.0, 0.0), (0.0, across, 0.0), (0.0, 0.0, 3 / 10 * self.radius**2))

    def reach(self, direction: Vector) -> float:
        """To its apex or its rim."""
        up = direction[2] * self.height / 2
        return max(up, math.hypot(direction[0], direction[1]) * self.radius - up)

    def facets(self) -> Facets:
        """A side and a base."""
        from wmspec.sim.shapes.facets import Row, disc, join, lathe

        r, h = float(self.radius), float(self.height)
        out, up = h / math.hypot(r, h), r / math.hypot(r, h)
        side: list[Row] = [(r, -h / 2, out, up, 0), (0, h / 2, out, up, 1)]
        return join([lathe(side), disc(r, -h / 2, -1.0)])

    def unwrapped(self, facets: Facets, every: Array) -> Array:
        """Wound around the side, flat on the base."""
        from wmspec.sim.shapes.texcoords import capped

        return capped(facets, self.radius, math.hypot(self.height, self.radius), every)

    def corners(self) -> Array:
        """Points around the base, and the apex."""
        import numpy as np

        turn = np.arange(SIDES) * (2 * math.pi / SIDES)
        base = np.full(SIDES, -self.height / 2)
        rim = np.stack([self.radius * np.cos(turn), self.radius * np.sin(turn), base], axis=1)
        return np.vstack([rim, [0.0, 0.0, self.height / 2]])

    def depths_at(self, point: Array) -> list[tuple[float, Array]]:
        """Its base and the slanting side."""
        import numpy as np

        from wmspec.sim.shapes.sides import below, round_

        slant = math.hypot(self.radius, self.height)
        depth, inwards = round_(0.0, point * [1.0, 1.0, 0.0])
        side = (depth * self.height + (self.height / 2 - point[2]) * self.radius) / slant
        slope = (inwards * self.height - np.array([0.0, 0.0, self.radius])) / slant
        return [*below((((0.0, 0.0, -1.0), self.height / 2),), point), (float(side), slope)]

    def prim(self) -> Gprim:
        """USD's own."""
        return round_gprim("Cone", self.radius, self.height, self.height / 2)

    @classmethod
    def read(cls, prim: Prim) -> tuple[Shape, float]:
        """Scaled equally across its axis."""
        across, along = prim.around()
        return cls(prim.positive("radius", 1.0) * across, prim.positive("height", 2.0) * along), 0.0
