"""A regular prism, upright and centred: a new shape as `docs/contributing.md` says how to add one."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

from wmspec.core.space import UP, Vector, dot
from wmspec.sim.shapes.shape import Flat, Parameter, Shape, Tensor, UnfitError, width_and_height

if TYPE_CHECKING:
    from wmspec.sim.shapes.facets import Facets


@dataclass(frozen=True)
class Prism(Shape):
    """Its `sides` are flat; its corners are `radius` (m) from z, one of them on +x; its ends are at ±`height` / 2."""

    sides: int
    radius: float
    height: float

    parameters = frozenset({"size", "radius", "height"})
    properties: ClassVar[Mapping[str, Parameter]] = {
        "sides": Parameter("number", "of a prism: how many sides it has, 6 if left out", least=3)
    }

    @classmethod
    def from_words(cls, words: Mapping[str, Any]) -> Shape:
        """Its `size` is the diameter of the circle around it, and its height."""
        across, up = width_and_height(words, tall=True)
        sides = words.get("sides", 6)
        if sides != int(sides):
            raise UnfitError(f"cannot have {sides:g} sides")
        return cls(int(sides), across / 2, up)

    @property
    def volume(self) -> float:
        """As many triangles as it has sides."""
        return self.sides / 2 * self.radius**2 * math.sin(2 * math.pi / self.sides) * self.height

    @property
    def tensor(self) -> Tensor:
        """Of a regular polygon, the mean of x² about its middle is R² (2 + cos 2π/n) / 12."""
        x, z = self.radius**2 * (2 + math.cos(2 * math.pi / self.sides)) / 12, self.height**2 / 12
        return ((x + z, 0.0, 0.0), (0.0, x + z, 0.0), (0.0, 0.0, 2 * x))

    def reach(self, direction: Vector) -> float:
        """To its furthest corner."""
        return max(dot(corner, direction) for corner in self._ring) + abs(direction[2]) * self.height / 2

    @property
    def flat_faces(self) -> tuple[Flat, ...]:
        """Its ends, and its sides."""
        away = self.radius * math.cos(math.pi / self.sides)
        turns = [(2 * i + 1) * math.pi / self.sides for i in range(self.sides)]
        ends = ((UP, self.height / 2), ((0.0, 0.0, -1.0), self.height / 2))
        return (*ends, *(((math.cos(t), math.sin(t), 0.0), away) for t in turns))

    def facets(self) -> Facets:
        """Its corners, and fans of triangles on its ends."""
        import numpy as np

        from wmspec.sim.shapes.facets import smooth

        n, ring = self.sides, np.array(self._ring)
        up = np.array([0, 0, self.height / 2])
        points = np.concatenate([ring - up, ring + up])
        faces = [(0, i + 1, i) for i in range(1, n - 1)] + [(n, n + i, n + i + 1) for i in range(1, n - 1)]
        for i in range(n):
            j = (i + 1) % n
            faces += [(i, j, n + j), (i, n + j, n + i)]
        return smooth(points, np.array(faces, np.int32))

    @property
    def _ring(self) -> list[Vector]:
        turns = [2 * math.pi * i / self.sides for i in range(self.sides)]
        return [(self.radius * math.cos(t), self.radius * math.sin(t), 0.0) for t in turns]
