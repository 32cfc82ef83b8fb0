"""A rod along a path: handles, taps, lamp arms, hooks."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import TYPE_CHECKING, Any, ClassVar

from wmspec.core.space import Pose, Vector, add, cross, dot, times, unit
from wmspec.sim.shapes.shape import Parameter, Shape, Tensor, UnfitError
from wmspec.sim.shapes.tube import THICKNESS

if TYPE_CHECKING:
    from wmspec.sim.shapes.facets import Facets

SIDES = 16
"""The rod is a prism of so many sides, mitred where the path bends: that is what it weighs, and how it is touched."""
CLOSEST = 1e-6
"""Points that are no further apart (m) are one: a rod between them has no weight that could be told from rounding."""


@dataclass(frozen=True)
class Sweep(Shape):
    """`along`: the points (m) of the path of its middle; the circle around its sides is `thickness` (m) wide."""

    along: tuple[Vector, ...]
    thickness: float

    parameters = frozenset()
    properties: ClassVar[Mapping[str, Parameter]] = {
        "along": Parameter("path", "of a sweep: the points of its path, (x, y, z)"),
        "thickness": THICKNESS,
    }
    convex = False

    @classmethod
    def from_words(cls, words: Mapping[str, Any]) -> Shape:
        """The middle is where the path has (0, 0, 0). It is 1 cm thick unless its `thickness` is said."""
        along = words.get("along", ())
        if len(along) < 2 or any(math.dist(a, b) < CLOSEST for a, b in pairwise(along)):
            raise UnfitError("needs two points or more along its path, each apart from the next", "along")
        made = cls(tuple(along), words.get("thickness", 0.01))
        for (p, q), (a, b) in zip(pairwise(made.along), pairwise(made._rings), strict=True):
            way = add(q, times(-1.0, p))
            if not all(dot(way, add(end, times(-1.0, start))) > 0 for start, end in zip(a, b, strict=True)):
                raise UnfitError("bends too sharply for its thickness", "along")
        return made

    @property
    def volume(self) -> float:
        """A mitred prism holds its cross-section as often as its path is long."""
        area = SIDES / 2 * math.sin(2 * math.pi / SIDES) * (self.thickness / 2) ** 2
        return area * sum(math.dist(a, b) for a, b in pairwise(self.along))

    @property
    def center(self) -> Vector:
        """Of its polyhedron."""
        x, y, z = self._solid.center_mass.tolist()
        return (x, y, z)

    @property
    def tensor(self) -> Tensor:
        """Of its polyhedron."""
        x, y, z = (self._solid.moment_inertia / self._solid.mass).tolist()
        return (tuple(x), tuple(y), tuple(z))

    def reach(self, direction: Vector) -> float:
        """To its furthest corner."""
        return max(dot(direction, point) for ring in self._rings for point in ring)

    @property
    def sizes(self) -> tuple[float, ...]:
        """Its path may be anywhere."""
        return (self.thickness, self.volume)

    def facets(self) -> Facets:
        """Its sides, s around and t along the path, and both ends."""
        import numpy as np

        from wmspec.sim.shapes.facets import join, quads, smooth

        rings = np.array([[*ring, ring[0]] for ring in self._rings])
        lengths = np.cumsum([0.0, *(math.dist(a, b) for a, b in pairwise(self.along))])
        s, t = np.meshgrid(np.linspace(0, 1, SIDES + 1), lengths / lengths[-1])
        first = (np.arange(len(rings) - 1)[:, None] * (SIDES + 1) + np.arange(SIDES)).reshape(-1)
        sides = quads(first, SIDES + 1).astype(np.int32)
        made = [smooth(rings.reshape(-1, 3), sides, np.stack([s.ravel(), t.ravel()], axis=1))]
        fan = np.array([(0, i, i + 1) for i in range(1, SIDES - 1)], np.int32)
        turns = np.arange(SIDES) * 2 * math.pi / SIDES
        disc = 0.5 + np.stack([np.cos(turns), np.sin(turns)], axis=1) / 2
        ends = ((rings[0, :-1], fan[:, ::-1]), (rings[-1, :-1], fan))
        return join([*made, *(smooth(points, faces, disc) for points, faces in ends)])

    def pieces(self) -> tuple[tuple[Shape, Pose], ...]:
        """A prism for each straight part."""
        return self._pieces

    @cached_property
    def _pieces(self) -> tuple[tuple[Shape, Pose], ...]:
        from wmspec.sim.shapes.mesh import hulls

        return hulls([*a, *b] for a, b in pairwise(self._rings))

    @cached_property
    def _solid(self) -> Any:
        import numpy as np
        import trimesh

        n, count = SIDES, len(self._rings)
        faces = [(0, i + 1, i) for i in range(1, n - 1)]
        faces += [((count - 1) * n, (count - 1) * n + i, (count - 1) * n + i + 1) for i in range(1, n - 1)]
        for ring in range(0, (count - 1) * n, n):
            for i in range(n):
                a, b = ring + i, ring + (i + 1) % n
                faces += [(a, b, b + n), (a, b + n, a + n)]
        return trimesh.Trimesh(np.array(self._rings).reshape(-1, 3), faces, process=False)

    @cached_property
    def _rings(self) -> tuple[tuple[Vector, ...], ...]:
        """The corners of the prism where the path begins, bends and ends."""
        ways = [unit(add(b, times(-1.0, a))) for a, b in pairwise(self.along)]
        least = min(range(3), key=lambda i: abs(ways[0][i]))
        aside = unit(cross(ways[0], ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))[least]))
        up = cross(ways[0], aside)
        turns = [2 * math.pi * i / SIDES for i in range(SIDES)]
        half = self.thickness / 2
        ring = [add(self.along[0], add(times(half * math.cos(t), aside), times(half * math.sin(t), up))) for t in turns]
        rings = [tuple(ring)]
        for way, middle, following in zip(ways, self.along[1:], [*ways[1:], ways[-1]], strict=True):
            normal = add(way, following)
            rings.append(tuple(_onto(point, way, middle, normal) for point in rings[-1]))
        return tuple(rings)


def _onto(point: Vector, way: Vector, middle: Vector, normal: Vector) -> Vector:
    """Where a point meets a plane, going one way; far behind it if it never does."""
    along = dot(way, normal)
    if along <= 1e-6:
        return add(point, times(-1.0, way))
    return add(point, times(dot(add(middle, times(-1.0, point)), normal) / along, way))
