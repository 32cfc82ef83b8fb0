"""Tubes along z: cylinders with a round hole."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

from wmspec.sim.shapes.lathe import Lathe
from wmspec.sim.shapes.shape import Parameter, Shape, UnfitError, width_and_height

THICKNESS = Parameter("length", "thickness of the wall of a tube, of the ring of a torus, or of a sweep", above=0)


@dataclass(frozen=True)
class Tube(Lathe):
    """A lathe with an upright rectangular profile."""

    parameters = frozenset({"size", "radius", "height"})
    properties: ClassVar[Mapping[str, Parameter]] = {"thickness": THICKNESS}

    @classmethod
    def from_words(cls, words: Mapping[str, Any]) -> Shape:
        """`size` is outer diameter and height; the wall defaults to a tenth of the diameter."""
        across, up = width_and_height(words, tall=True)
        wall = words.get("thickness", across / 10)
        if wall >= across / 2:
            raise UnfitError("is filled by its own wall", "thickness")
        outer, half = across / 2, up / 2
        return cls(((outer - wall, -half), (outer, -half), (outer, half), (outer - wall, half)))

    @property
    def words(self) -> Mapping[str, Any]:
        """The outer radius, the height and the wall."""
        (inner, low), (outer, _), (_, high), _ = self.profile
        return {"radius": outer, "height": high - low, "thickness": outer - inner}
