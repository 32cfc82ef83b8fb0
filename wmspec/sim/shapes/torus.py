"""A torus: a ring around z."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, ClassVar

from wmspec.core.space import Pose, Vector
from wmspec.sim.shapes.lathe import Lathe
from wmspec.sim.shapes.shape import Parameter, Shape, Tensor, UnfitError, across_and_up
from wmspec.sim.shapes.tube import THICKNESS

if TYPE_CHECKING:
    from wmspec.sim.shapes.facets import Facets
    from wmspec.sim.shapes.shape import Array

_DRAWN, _TOUCHED = 24, 12  # corners of the round profile


@dataclass(frozen=True)
class Torus(Shape):
    """All that is nearer than `thick` / 2 to a circle of a `radius` (m) around z."""

    radius: float
    thick: float

    parameters = frozenset({"size", "radius"})
    properties: ClassVar[Mapping[str, Parameter]] = {"thickness": THICKNESS}
    symmetry = "axis"
    rim = True
    convex = False

    @classmethod
    def from_words(cls, words: Mapping[str, Any]) -> Shape:
        """Its `size` is its outer diameter; the ring is a quarter of that thick unless it is said."""
        across, _ = across_and_up(words)
        thick = words.get("thickness", across / 4)
        if thick >= across / 2:
            raise UnfitError("has no hole", "thickness")
        return cls((across - thick) / 2, thick)

    @property
    def words(self) -> Mapping[str, Any]:
        """Its outer radius, and how thick the ring is."""
        return {"radius": self.radius + self.thick / 2, "thickness": self.thick}

    @property
    def volume(self) -> float:
        """Of Pappus and Guldin."""
        return math.pi**2 * self.radius * self.thick**2 / 2

    @property
    def tensor(self) -> Tensor:
        """Of a torus with the radii R and r: (R² + 3/4 r²) along the axis, R² / 2 + 5/8 r² across."""
        big, small = self.radius**2, self.thick**2 / 4
        across = big / 2 + 5 / 8 * small
        return ((across, 0.0, 0.0), (0.0, across, 0.0), (0.0, 0.0, big + 3 / 4 * small))

    def reach(self, direction: Vector) -> float:
        """That of its circle, and of a ball."""
        return math.hypot(direction[0], direction[1]) * self.radius + math.hypot(*direction) * self.thick / 2

    def facets(self) -> Facets:
        """A round profile, turned."""
        return self._turned(_DRAWN).facets()

    def unwrapped(self, facets: Facets, every: Array) -> Array:
        """Wound around, both ways."""
        from wmspec.sim.shapes.texcoords import wound

        return wound(facets, self.radius, math.pi * self.thick, every)

    def pieces(self) -> tuple[tuple[Shape, Pose], ...]:
        """Sectors of the ring."""
        return self._pieces

    @cached_property
    def _pieces(self) -> tuple[tuple[Shape, Pose], ...]:
        return self._turned(_TOUCHED).pieces()

    def _turned(self, corners: int) -> Lathe:
        """The lathe of a profile with so many corners."""
        turns = [2 * math.pi * i / corners for i in range(corners)]
        small = self.thick / 2
        return Lathe(tuple((self.radius + small * math.cos(t), small * math.sin(t)) for t in turns))
