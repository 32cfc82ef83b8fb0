"""Obstacles of cars and walkers: outlines of objects on the ground, and distances to them."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import TYPE_CHECKING

from wmspec.compile.layout.geometry import all_pieces
from wmspec.compile.layout.motion import carriers
from wmspec.compile.layout.solids import PlacedShape, bounds, corners
from wmspec.core.space import IDENTITY, Pose, Vector
from wmspec.sim.shapes import Shape

if TYPE_CHECKING:
    from wmspec.compile.layout.evaluator import Evaluator

Point = tuple[float, float]

#: Maximum rounding error of a distance (m).
_ROUNDING = 1e-9


@dataclass(frozen=True)
class Outline:
    """The convex outline of a part of an object, seen from above: `corners` (m), anticlockwise."""

    name: str
    corners: tuple[Point, ...]

    @cached_property
    def middle(self) -> Point:
        """The mean of its corners, m."""
        n = len(self.corners)
        return (sum(x for x, _ in self.corners) / n, sum(y for _, y in self.corners) / n)

    @cached_property
    def radius(self) -> float:
        """Maximum distance (m) of a corner from the middle."""
        return max(math.dist(self.middle, corner) for corner in self.corners)

    @cached_property
    def sides(self) -> tuple[tuple[Point, Point], ...]:
        """The ends of each side."""
        return tuple(zip(self.corners, (*self.corners[1:], self.corners[0]), strict=True))

    @cached_property
    def edges(self) -> tuple[tuple[float, float, float, float, float], ...]:
        """The start (x, y) of each side, its vector (x, y), and its squared length; m, m²."""
        return tuple((a[0], a[1], b[0] - a[0], b[1] - a[1], math.dist(a, b) ** 2) for a, b in self.sides)

    def least_distance(self, point: Point) -> float:
        """Return a lower bound (m) of the distance of a point, which is quick to compute."""
        return math.dist(self.middle, point) - self.radius - _ROUNDING

    def contains(self, point: Point) -> bool:
        """Whether a point is within the outline."""
        if self.least_distance(point) > 0:
            return False
        px, py = point
        for x, y, dx, dy, _ in self.edges:  # noqa: SIM110  a loop takes half the time of `all`
            if dx * (py - y) - dy * (px - x) < 0:
                return False
        return True

    def distance(self, point: Point) -> float:
        """Return the distance (m) of a point; 0 within the outline."""
        if self.contains(point):
            return 0.0
        least, (px, py) = math.inf, point
        for x, y, dx, dy, square in self.edges:
            share = min(1.0, max(0.0, ((px - x) * dx + (py - y) * dy) / square))
            least = min(least, math.dist(point, (x + share * dx, y + share * dy)))
        return least

    def meets(self, other: Outline) -> bool:
        """Whether two outlines overlap, by the separating axis test."""
        return not (_is_separated(self, other) or _is_separated(other, self))


def clearance(outlines: Iterable[Outline], point: Point) -> float:
    """Return the distance (m) of a point from the nearest outline; infinite if there is none."""
    least = math.inf
    for outline in outlines:
        if outline.least_distance(point) < least:
            least = min(least, outline.distance(point))
    return least


def obstacles(values: Evaluator, low: float, high: float) -> tuple[Outline, ...]:
    """Return the initial outlines of all visible or touchable, uncarried objects between two heights (m)."""
    carried = carriers(values)
    names = (t.name for t in values.spec.things if t.kind == "object" and t.name not in carried)
    kept = (name for name in names if values.is_present(name) and _has_any(values, name, ("drawn", "solid")))
    return tuple(outline for name in kept for outline in _outlines(values, name, low, high))


def object_outlines(values: Evaluator, name: str) -> tuple[Outline, ...]:
    """Return the outlines of the parts of one object, at any height."""
    return tuple(_outlines(values, name, -math.inf, math.inf))


def _outlines(values: Evaluator, name: str, low: float, high: float) -> list[Outline]:
    """Return the outlines of the parts of an object that reach between two heights."""
    outlines = []
    for _, piece in all_pieces(values, name):
        box = _box(piece, values.pose(name))
        if min(z for *_, z in box) < high and max(z for *_, z in box) > low:
            outlines.append(Outline(name, hull([(x, y) for x, y, _ in box])))
    return outlines


def _has_any(values: Evaluator, name: str, properties: Sequence[str]) -> bool:
    return any(not values.has(name, p) or values.flag(name, p) for p in properties)


def _box(piece: PlacedShape, pose: Pose) -> list[Vector]:
    """Return the world corners of the box around a solid, along the solid's own axes."""
    placed = pose.compose(piece.pose)
    return [placed.apply(corner) for corner in _own_corners(piece.solid)]


@lru_cache(4096)
def _own_corners(solid: Shape) -> tuple[Vector, ...]:
    return tuple(corners(bounds([PlacedShape(solid, IDENTITY)], IDENTITY)))


def hull(points: Sequence[Point]) -> tuple[Point, ...]:
    """Return the convex hull, anticlockwise (A. M. Andrew's monotone chain, Information Processing Letters 9, 1979)."""
    ordered = sorted({(round(x, 9), round(y, 9)) for x, y in points})
    halves: list[Point] = []
    for way in (ordered, ordered[::-1]):
        half: list[Point] = []
        for point in way:
            while len(half) >= 2 and _left(half[-2], half[-1], point) <= 0:
                half.pop()
            half.append(point)
        halves += half[:-1]
    return tuple(halves)


def _left(a: Point, b: Point, point: Point) -> float:
    """Return twice the signed area of the triangle `a`, `b`, `point`; positive on the left."""
    return (b[0] - a[0]) * (point[1] - a[1]) - (b[1] - a[1]) * (point[0] - a[0])


def _is_separated(one: Outline, other: Outline) -> bool:
    """Whether a side of one outline has all of the other to its right."""
    return any(all(_left(a, b, corner) <= 0 for corner in other.corners) for a, b in one.sides)
