"""A tube along z: a cylinder with a round hole."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

from wmspec.sim.shapes.lathe import Lathe
from wmspec.sim.shapes.shape import Parameter, Shape, UnfitError, across_and_up

THICKNESS = Parameter("length", "of the wall of a tube, of the ring of a torus, of a sweep", above=0)


@dataclass(frozen=True)
class Tube(Lathe):
    """A lathe whose profile is upright and rectangular."""

    parameters = frozenset({"size", "radius", "height"})
    properties: ClassVar[Mapping[str, Parameter]] = {"thickness": THICKNESS}

    @classmethod
    def from_words(cls, words: Mapping[str, Any]) -> Shape:
        """Its `size` is its outer diameter and its height; its wall is a tenth of the diameter unless it is said."""
        across, up = across_and_up(words, tall=True)
        wall = words.get("thickness", across / 10)
        if wall >= across / 2:
            raise UnfitError("is filled by its own wall", "thickness")
        outer, half = across / 2, up / 2
        return cls(((outer - wall, -half), (outer, -half), (outer, half), (outer - wall, half)))

    @property
    def words(self) -> Mapping[str, Any]:
        """Its outer radius, its height and its wall."""
        (inner, low), (outer, _), (_, high), _ = self.profile
        return {"radius": outer, "height": high - low, "thickness": outer - inner}
