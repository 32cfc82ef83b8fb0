"""Cones along z, centred at half height."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from wmspec.core.space import Vector
from wmspec.sim.shapes.shape import Gprim, Prim, Shape, Tensor, round_gprim, width_and_height

if TYPE_CHECKING:
    from wmspec.sim.shapes.facets import Facets
    from wmspec.sim.shapes.shape import Array

CONE_SIDES = 48  # of the collision hull


@dataclass(frozen=True)
class Cone(Shape):
    """Base of `radius` (m) at -`height` / 2, apex at +`height` / 2."""

    radius: float
    height: float

    parameters = frozenset({"size", "radius", "height"})
    prims = ("Cone",)
    symmetry = "axis"
    rim = True

    @classmethod
    def from_words(cls, words: Mapping[str, Any]) -> Shape:
        """`size` is diameter and height."""
        across, up = width_and_height(words, tall=True)
        return cls(across / 2, up)

    @property
    def volume(self) -> float:
        """π r² h / 3."""
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
        """Distance of apex or rim."""
        up = direction[2] * self.height / 2
        return max(up, math.hypot(direction[0], direction[1]) * self.radius - up)

    def facets(self) -> Facets:
        """Side and base."""
        from wmspec.sim.shapes.facets import Row, disc, join, lathe

        r, h = float(self.radius), float(self.height)
        out, up = h / math.hypot(r, h), r / math.hypot(r, h)
        side: list[Row] = [(r, -h / 2, out, up, 0), (0, h / 2, out, up, 1)]
        return join([lathe(side), disc(r, -h / 2, -1.0)])

    def unwrapped(self, facets: Facets, every: Array) -> Array:
        """Wrapped around the side, planar on the base."""
        from wmspec.sim.shapes.texcoords import capped_texcoords

        return capped_texcoords(facets, self.radius, math.hypot(self.height, self.radius), every)

    def corners(self) -> Array:
        """Points around the base, and the apex."""
        import numpy as np

        turn = np.arange(CONE_SIDES) * (2 * math.pi / CONE_SIDES)
        base = np.full(CONE_SIDES, -self.height / 2)
        rim = np.stack([self.radius * np.cos(turn), self.radius * np.sin(turn), base], axis=1)
        return np.vstack([rim, [0.0, 0.0, self.height / 2]])

    def depths_at(self, point: Array) -> list[tuple[float, Array]]:
        """Depth below base and side."""
        import numpy as np

        from wmspec.sim.shapes.sides import plane_depths, round_depth

        slant = math.hypot(self.radius, self.height)
        depth, inwards = round_depth(0.0, point * [1.0, 1.0, 0.0])
        side = (depth * self.height + (self.height / 2 - point[2]) * self.radius) / slant
        slope = (inwards * self.height - np.array([0.0, 0.0, self.radius])) / slant
        return [*plane_depths((((0.0, 0.0, -1.0), self.height / 2),), point), (float(side), slope)]

    def prim(self) -> Gprim:
        """USD's cone."""
        return round_gprim("Cone", self.radius, self.height, self.height / 2)

    @classmethod
    def read(cls, prim: Prim) -> tuple[Shape, float]:
        """The scale must be equal across the axis."""
        across, along = prim.around()
        return cls(prim.positive("radius", 1.0) * across, prim.positive("height", 2.0) * along), 0.0
