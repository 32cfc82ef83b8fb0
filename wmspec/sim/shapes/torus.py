"""Tori around z."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, ClassVar

from wmspec.core.space import Pose, Vector
from wmspec.sim.shapes.lathe import Lathe
from wmspec.sim.shapes.shape import Parameter, Shape, Tensor, UnfitError, width_and_height
from wmspec.sim.shapes.tube import THICKNESS

if TYPE_CHECKING:
    from wmspec.sim.shapes.facets import Facets
    from wmspec.sim.shapes.shape import Array

_DRAWN, _TOUCHED = 24, 12  # corners of the round profile


@dataclass(frozen=True)
class Torus(Shape):
    """All points within `thick` / 2 of a circle of `radius` (m) around z."""

    radius: float
    thick: float

    parameters = frozenset({"size", "radius"})
    properties: ClassVar[Mapping[str, Parameter]] = {"thickness": THICKNESS}
    symmetry = "axis"
    rim = True
    convex = False

    @classmethod
    def from_words(cls, words: Mapping[str, Any]) -> Shape:
        """`size` is the outer diameter; the thickness defaults to a quarter of it."""
        across, _ = width_and_height(words)
        thick = words.get("thickness", across / 4)
        if thick >= across / 2:
            raise UnfitError("has no hole", "thickness")
        return cls((across - thick) / 2, thick)

    @property
    def words(self) -> Mapping[str, Any]:
        """The outer radius and the thickness."""
        return {"radius": self.radius + self.thick / 2, "thickness": self.thick}

    @property
    def volume(self) -> float:
        """Pappus's centroid theorem."""
        return math.pi**2 * self.radius * self.thick**2 / 2

    @property
    def tensor(self) -> Tensor:
        """For radii R and r: R² + 3/4 r² along the axis, R² / 2 + 5/8 r² across."""
        big, small = self.radius**2, self.thick**2 / 4
        across = big / 2 + 5 / 8 * small
        return ((across, 0.0, 0.0), (0.0, across, 0.0), (0.0, 0.0, big + 3 / 4 * small))

    def reach(self, direction: Vector) -> float:
        """Circle plus sphere."""
        return math.hypot(direction[0], direction[1]) * self.radius + math.hypot(*direction) * self.thick / 2

    def facets(self) -> Facets:
        """A revolved circle."""
        return self._turned(_DRAWN).facets()

    def unwrapped(self, facets: Facets, every: Array) -> Array:
        """Wrapped in both directions."""
        from wmspec.sim.shapes.texcoords import wrapped_texcoords

        return wrapped_texcoords(facets, self.radius, math.pi * self.thick, every)

    @cached_property
    def pieces(self) -> tuple[tuple[Shape, Pose], ...]:
        """Sectors of the ring."""
        return self._turned(_TOUCHED).pieces

    def _turned(self, corners: int) -> Lathe:
        """Return the lathe of a profile with `corners` corners."""
        turns = [2 * math.pi * i / corners for i in range(corners)]
        small = self.thick / 2
        return Lathe(tuple((self.radius + small * math.cos(t), small * math.sin(t)) for t in turns))
