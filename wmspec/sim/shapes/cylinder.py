"""Cylinders along z, centred."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from wmspec.core.space import UP, Vector
from wmspec.sim.shapes.shape import Gprim, Prim, Shape, Tensor, round_gprim, width_and_height

if TYPE_CHECKING:
    from wmspec.sim.shapes.facets import Facets
    from wmspec.sim.shapes.shape import Array


@dataclass(frozen=True)
class Cylinder(Shape):
    """All points within `radius` (m) of z between caps at ±`height` / 2."""

    radius: float
    height: float

    parameters = frozenset({"size", "radius", "height"})
    prims = ("Cylinder", "Cylinder_1")
    engine_kind = "cylinder"
    symmetry = "axis"
    rim = True

    @classmethod
    def from_words(cls, words: Mapping[str, Any]) -> Shape:
        """`size` is diameter and height."""
        across, up = width_and_height(words, tall=True)
        return cls(across / 2, up)

    @property
    def volume(self) -> float:
        """π r² h."""
        return math.pi * self.radius**2 * self.height

    @property
    def tensor(self) -> Tensor:
        """Meriam and Kraige, Engineering Mechanics: Dynamics, table D/4."""
        across = self.radius**2 / 4 + self.height**2 / 12
        return ((across, 0.0, 0.0), (0.0, across, 0.0), (0.0, 0.0, self.radius**2 / 2))

    def reach(self, direction: Vector) -> float:
        """Distance of the rim."""
        return math.hypot(direction[0], direction[1]) * self.radius + abs(direction[2]) * self.height / 2

    def facets(self) -> Facets:
        """Side and two caps."""
        from wmspec.sim.shapes.facets import Row, disc, join, lathe

        r, h = float(self.radius), float(self.height)
        side: list[Row] = [(r, -h / 2, 1, 0, 0), (r, h / 2, 1, 0, 1)]
        return join([lathe(side), disc(r, -h / 2, -1.0), disc(r, h / 2, 1.0)])

    def unwrapped(self, facets: Facets, every: Array) -> Array:
        """Wrapped around the side, planar on the caps."""
        from wmspec.sim.shapes.texcoords import capped_texcoords

        return capped_texcoords(facets, self.radius, self.height, every)

    def depths_at(self, point: Array) -> list[tuple[float, Array]]:
        """Depth below caps and side."""
        from wmspec.sim.shapes.sides import plane_depths, round_depth

        caps = plane_depths((((0.0, 0.0, -1.0), self.height / 2), (UP, self.height / 2)), point)
        return [*caps, round_depth(self.radius, point * [1.0, 1.0, 0.0])]

    def prim(self) -> Gprim:
        """USD's cylinder."""
        return round_gprim("Cylinder", self.radius, self.height, self.height / 2)

    @classmethod
    def read(cls, prim: Prim) -> tuple[Shape, float]:
        """The scale must be equal across the axis."""
        across, along = prim.around()
        return cls(prim.radius(1.0) * across, prim.positive("height", 2.0) * along), 0.0
