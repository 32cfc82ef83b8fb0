"""Solids of revolution: a profile revolved about z."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, ClassVar

from wmspec.core.space import Pose, Vector
from wmspec.sim.shapes.outline import Outline, checked_outline, convex, integral, smooth_runs
from wmspec.sim.shapes.shape import Parameter, Shape, Tensor, UnfitError

if TYPE_CHECKING:
    from wmspec.sim.shapes.facets import Facets
    from wmspec.sim.shapes.shape import Array

SECTORS = 16
"""Number of parts of a ring, each with a corner in its middle: a polygon of 32 sides."""


@dataclass(frozen=True)
class Lathe(Shape):
    """`profile`: the outline of one half, points (radius, height) in m, counter-clockwise as (x, z)."""

    profile: Outline

    parameters = frozenset()
    properties: ClassVar[Mapping[str, Parameter]] = {
        "profile": Parameter(
            "points", "of a lathe: the points (radius, height) of the outline that is rotated about the vertical"
        )
    }
    symmetry = "axis"
    rim = True
    convex = False
    hollow = True

    @classmethod
    def from_words(cls, words: Mapping[str, Any]) -> Shape:
        """The origin is (0, 0) of the profile."""
        profile = checked_outline(words.get("profile", ()), "profile")
        if any(r < 0 for r, _ in profile):
            raise UnfitError("has a profile on both sides of the axis; radii are 0 or more", "profile")
        return Lathe(profile)

    @property
    def volume(self) -> float:
        """Pappus's centroid theorem."""
        return math.pi * integral(self.profile, lambda r, _: r**2)

    @property
    def center(self) -> Vector:
        """On the axis."""
        return (0.0, 0.0, math.pi * integral(self.profile, lambda r, z: r**2 * z) / self.volume)

    @property
    def tensor(self) -> Tensor:
        """Exact, for the round solid and not its facets."""
        along = math.pi / 2 * integral(self.profile, lambda r, _: r**4) / self.volume
        height = math.pi * integral(self.profile, lambda r, z: r**2 * z**2) / self.volume - self.center[2] ** 2
        across = along / 2 + height
        return ((across, 0.0, 0.0), (0.0, across, 0.0), (0.0, 0.0, along))

    def reach(self, direction: Vector) -> float:
        """Distance of the extreme circle."""
        out = math.hypot(direction[0], direction[1])
        return max(out * r + direction[2] * z for r, z in self.profile)

    def floor(self, x: float, y: float) -> float | None:
        """Height at which the profile is first left from below."""
        r = max(math.hypot(x, y), 1e-9)
        ends = zip(self.profile, (*self.profile[1:], self.profile[0]), strict=True)
        crossed = [(a, b) for a, b in ends if min(a[0], b[0]) <= r < max(a[0], b[0])]
        heights = sorted(low + (r - near) / (far - near) * (high - low) for (near, low), (far, high) in crossed)
        return heights[1] if heights else None

    @property
    def sizes(self) -> tuple[float, ...]:
        """Coordinates of the profile may be negative."""
        return (self.volume,)

    def facets(self) -> Facets:
        """Each smooth run of the profile, revolved; t runs along the whole profile."""
        from wmspec.sim.shapes.facets import CREASE, Row, join, lathe

        made, length = [], self._length
        gone = 0.0
        for run in smooth_runs(self.profile, CREASE):
            rows: list[Row] = []
            for i, ((r, z), (out, up)) in enumerate(run):
                gone += math.dist(run[i - 1][0], (r, z)) if i else 0.0
                rows.append((r, z, out, up, gone / length))
            if any(row[0] > 0 for row in rows):
                made.append(lathe(rows))
        return join(made)

    def unwrapped(self, facets: Facets, every: Array) -> Array:
        """Wrapped around, and along the profile."""
        from wmspec.sim.shapes.texcoords import wrapped_texcoords

        return wrapped_texcoords(facets, max(r for r, _ in self.profile), self._length, every)

    @cached_property
    def pieces(self) -> tuple[tuple[Shape, Pose], ...]:
        """Convex parts of the profile: revolved as a whole at the axis, in sectors elsewhere."""
        from wmspec.sim.shapes.mesh import hulls

        return hulls(points for part in convex(self.profile) for points in _turned(part))

    @property
    def _length(self) -> float:
        return sum(math.dist(a, b) for a, b in zip(self.profile, (*self.profile[1:], self.profile[0]), strict=True))


def _turned(part: Outline) -> list[Array]:
    """Return the corners (n, 3) of the convex parts of a revolved convex outline."""
    import numpy as np

    def at(turns: Array) -> Array:
        r, z = np.array(part).T
        turns = turns[:, None]
        return np.stack(np.broadcast_arrays(r * np.cos(turns), r * np.sin(turns), z), axis=-1).reshape(-1, 3)

    step = 2 * math.pi / SECTORS
    if sum(r == 0 for r, _ in part) >= 2:
        most = max(8, min(2 * SECTORS, 240 // len(part)))
        return [at(np.arange(most, dtype=np.float64) * (2 * math.pi / most))]
    return [at(np.array([i - 0.5, i, i + 0.5]) * step) for i in range(SECTORS)]
