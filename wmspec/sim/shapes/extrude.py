"""Extruded outlines: letters, brackets, stairs, arrows."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, ClassVar

from wmspec.core.space import Pose, Vector
from wmspec.sim.shapes.outline import Outline, checked_outline, convex, integral, smooth_runs, triangles
from wmspec.sim.shapes.shape import Parameter, Shape, Tensor, UnfitError

if TYPE_CHECKING:
    from wmspec.sim.shapes.facets import Facets


@dataclass(frozen=True)
class Extrude(Shape):
    """`outline`: points (x, z) in m seen from the front, counter-clockwise; ±`depth` / 2 along y."""

    outline: Outline
    depth: float

    parameters = frozenset()
    properties: ClassVar[Mapping[str, Parameter]] = {
        "outline": Parameter(
            "points", "of an extruded shape: the points (right, up) of its outline, seen from the front"
        ),
        "depth": Parameter("length", "of an extruded shape: its length from front to back", above=0),
    }
    convex = False

    @classmethod
    def from_words(cls, words: Mapping[str, Any]) -> Shape:
        """The origin is (0, 0) of the outline. `depth` defaults to `size`."""
        depth = words.get("depth", words["size"])
        if isinstance(depth, tuple):
            raise UnfitError("needs a `depth`", "size")
        return cls(checked_outline(words.get("outline", ()), "outline"), depth)

    @property
    def volume(self) -> float:
        """Area of the outline times depth."""
        return self._area * self.depth

    @property
    def center(self) -> Vector:
        """Centroid of the outline."""
        x = integral(self.outline, lambda x, _: x**2 / 2) / self._area
        z = integral(self.outline, lambda x, z: x * z) / self._area
        return (x, 0.0, z)

    @property
    def tensor(self) -> Tensor:
        """From second moments of the outline."""
        cx, _, cz = self.center
        x = integral(self.outline, lambda x, _: x**3 / 3) / self._area - cx**2
        z = integral(self.outline, lambda x, z: x * z**2) / self._area - cz**2
        xz = integral(self.outline, lambda x, z: x**2 / 2 * z) / self._area - cx * cz
        y = self.depth**2 / 12
        return ((y + z, 0.0, -xz), (0.0, x + z, 0.0), (-xz, 0.0, x + y))

    def reach(self, direction: Vector) -> float:
        """Distance of the extreme corner."""
        out = max(direction[0] * x + direction[2] * z for x, z in self.outline)
        return out + abs(direction[1]) * self.depth / 2

    @property
    def sizes(self) -> tuple[float, ...]:
        """Coordinates of the outline may be negative."""
        return (self._area, self.depth)

    def facets(self) -> Facets:
        """Sides along smooth runs of the outline, and both ends, each with the whole image."""
        import numpy as np

        from wmspec.sim.shapes.facets import CREASE, facets, join, quads

        made = []
        for run in smooth_runs(self.outline, CREASE):
            (x, z), (nx, nz) = (np.array([row[k] for row in run]).T for k in (0, 1))
            y, s = np.full(len(run), self.depth / 2), np.linspace(0, 1, len(run))
            points = np.concatenate([np.stack([x, y, z], 1), np.stack([x, -y, z], 1)])
            normals = np.tile(np.stack([nx, 0 * nx, nz], 1), (2, 1))
            st = np.stack([np.tile(s, 2), np.repeat([0.0, 1.0], len(run))], 1)
            made.append(facets(points, normals, st, quads(np.arange(len(run) - 1), len(run))))
        flat, faces = np.array(self.outline), np.array(triangles(self.outline))
        st = (flat - flat.min(axis=0)) / np.ptp(flat, axis=0)
        for way in (-1.0, 1.0):
            points = np.stack([flat[:, 0], np.full(len(flat), way * self.depth / 2), flat[:, 1]], 1)
            seen = st if way < 0 else np.stack([1 - st[:, 0], st[:, 1]], 1)
            turned = faces if way < 0 else faces[:, ::-1]
            made.append(facets(points, np.tile([0.0, way, 0.0], (len(flat), 1)), seen, turned))
        return join(made)

    @cached_property
    def pieces(self) -> tuple[tuple[Shape, Pose], ...]:
        """Extrusions of convex parts of the outline."""
        from wmspec.sim.shapes.mesh import hulls

        ends = (-self.depth / 2, self.depth / 2)
        return hulls([(x, y, z) for x, z in part for y in ends] for part in convex(self.outline))

    @property
    def _area(self) -> float:
        return integral(self.outline, lambda x, _: x)
