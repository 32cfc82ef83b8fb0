"""Rods along a path: handles, taps, lamp arms, hooks."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import TYPE_CHECKING, Any, ClassVar

from wmspec.core.space import Pose, Vector, add, cross, dot, scale, unit
from wmspec.sim.shapes.shape import Parameter, Shape, Tensor, UnfitError
from wmspec.sim.shapes.tube import THICKNESS

if TYPE_CHECKING:
    from wmspec.sim.shapes.facets import Facets

SWEEP_SIDES = 16
"""Number of sides of the prism, mitred at bends, that collides and has the mass."""
MIN_POINT_DISTANCE = 1e-6
"""m: closer points are merged, because the mass of a rod between them is lost in rounding."""


@dataclass(frozen=True)
class Sweep(Shape):
    """`along`: points (m) of the centre line; `thickness` (m): diameter of the circumscribed circle."""

    along: tuple[Vector, ...]
    thickness: float

    parameters = frozenset()
    properties: ClassVar[Mapping[str, Parameter]] = {
        "along": Parameter("path", "of a sweep: the points (x, y, z) of its path"),
        "thickness": THICKNESS,
    }
    convex = False

    @classmethod
    def from_words(cls, words: Mapping[str, Any]) -> Shape:
        """The origin is (0, 0, 0) of the path. `thickness` defaults to 1 cm."""
        along = words.get("along", ())
        if len(along) < 2 or any(math.dist(a, b) < MIN_POINT_DISTANCE for a, b in pairwise(along)):
            raise UnfitError("needs two points or more along its path, each apart from the next", "along")
        made = cls(tuple(along), words.get("thickness", 0.01))
        for (p, q), (a, b) in zip(pairwise(made.along), pairwise(made._rings), strict=True):
            way = add(q, scale(-1.0, p))
            if not all(dot(way, add(end, scale(-1.0, start))) > 0 for start, end in zip(a, b, strict=True)):
                raise UnfitError("bends too sharply for its thickness", "along")
        return made

    @property
    def volume(self) -> float:
        """Cross-section times length of the path."""
        area = SWEEP_SIDES / 2 * math.sin(2 * math.pi / SWEEP_SIDES) * (self.thickness / 2) ** 2
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
        """Distance of the extreme corner."""
        return max(dot(direction, point) for ring in self._rings for point in ring)

    @property
    def sizes(self) -> tuple[float, ...]:
        """Coordinates of the path may be negative."""
        return (self.thickness, self.volume)

    def facets(self) -> Facets:
        """Sides with s around and t along the path, and both ends."""
        import numpy as np

        from wmspec.sim.shapes.facets import join, quads, smooth

        rings = np.array([[*ring, ring[0]] for ring in self._rings])
        lengths = np.cumsum([0.0, *(math.dist(a, b) for a, b in pairwise(self.along))])
        s, t = np.meshgrid(np.linspace(0, 1, SWEEP_SIDES + 1), lengths / lengths[-1])
        first = (np.arange(len(rings) - 1)[:, None] * (SWEEP_SIDES + 1) + np.arange(SWEEP_SIDES)).reshape(-1)
        sides = quads(first, SWEEP_SIDES + 1).astype(np.int32)
        made = [smooth(rings.reshape(-1, 3), sides, np.stack([s.ravel(), t.ravel()], axis=1))]
        fan = np.array([(0, i, i + 1) for i in range(1, SWEEP_SIDES - 1)], np.int32)
        turns = np.arange(SWEEP_SIDES) * 2 * math.pi / SWEEP_SIDES
        disc = 0.5 + np.stack([np.cos(turns), np.sin(turns)], axis=1) / 2
        ends = ((rings[0, :-1], fan[:, ::-1]), (rings[-1, :-1], fan))
        return join([*made, *(smooth(points, faces, disc) for points, faces in ends)])

    @cached_property
    def pieces(self) -> tuple[tuple[Shape, Pose], ...]:
        """A prism for each straight part."""
        from wmspec.sim.shapes.mesh import hulls

        return hulls([*a, *b] for a, b in pairwise(self._rings))

    @cached_property
    def _solid(self) -> Any:
        import numpy as np
        import trimesh

        n, count = SWEEP_SIDES, len(self._rings)
        faces = [(0, i + 1, i) for i in range(1, n - 1)]
        faces += [((count - 1) * n, (count - 1) * n + i, (count - 1) * n + i + 1) for i in range(1, n - 1)]
        for ring in range(0, (count - 1) * n, n):
            for i in range(n):
                a, b = ring + i, ring + (i + 1) % n
                faces += [(a, b, b + n), (a, b + n, a + n)]
        return trimesh.Trimesh(np.array(self._rings).reshape(-1, 3), faces, process=False)

    @cached_property
    def _rings(self) -> tuple[tuple[Vector, ...], ...]:
        """Return the corners of the prism at the ends and bends of the path."""
        ways = [unit(add(b, scale(-1.0, a))) for a, b in pairwise(self.along)]
        least = min(range(3), key=lambda i: abs(ways[0][i]))
        aside = unit(cross(ways[0], ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))[least]))
        up = cross(ways[0], aside)
        turns = [2 * math.pi * i / SWEEP_SIDES for i in range(SWEEP_SIDES)]
        half = self.thickness / 2
        ring = [add(self.along[0], add(scale(half * math.cos(t), aside), scale(half * math.sin(t), up))) for t in turns]
        rings = [tuple(ring)]
        for way, middle, following in zip(ways, self.along[1:], [*ways[1:], ways[-1]], strict=True):
            normal = add(way, following)
            rings.append(tuple(_onto(point, way, middle, normal) for point in rings[-1]))
        return tuple(rings)


def _onto(point: Vector, way: Vector, middle: Vector, normal: Vector) -> Vector:
    """Return the intersection of a line and a plane; a far point if parallel."""
    along = dot(way, normal)
    if along <= 1e-6:
        return add(point, scale(-1.0, way))
    return add(point, scale(dot(add(middle, scale(-1.0, point)), normal) / along, way))
