"""Paths of carried objects: named forms or given points, rotated and traversed at constant speed."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from itertools import pairwise

from wmspec.core.space import ORIGIN, Vector, add, scale

#: Bends sharper than MIN_CORNER_ANGLE (rad) are corners; the turn happens within this share of the adjacent legs.
MIN_CORNER_ANGLE, CORNER_SHARE = math.radians(30), 0.1

#: Number of segments of a full circle; at a diameter of 40 cm the error is 0.1 mm.
CIRCLE_SEGMENTS = 96


def named_path(form: str, length: float, width: float) -> tuple[Vector, ...]:
    """Return the points (m) of a named path that starts at the origin along +x and deviates to +y.

    straight: to (length, 0). arc: a circular arc to the same end with sagitta `width`. zigzag: to the same end in four
    legs with amplitude `width`. circle: once around, through (length, 0). back_and_forth: to (length, 0) and back.
    square, triangle: once around, to the left, with sides of that length, from the middle of a side.
    """
    return _FORMS[form](length, width)


def rotated_points(points: Sequence[Sequence[float]], angle: float) -> tuple[Vector, ...]:
    """Return points (x, y) or (x, y, z) relative to the first, rotated about the vertical."""
    cos, sin = math.cos(angle), math.sin(angle)
    around = tuple((cos * x - sin * y, sin * x + cos * y, z[0] if z else 0.0) for x, y, *z in points)
    return around if around and around[0] == ORIGIN else (ORIGIN, *around)


def timed_points(points: Sequence[Vector], duration: float) -> tuple[tuple[Vector, ...], tuple[float, ...]]:
    """Return the points without consecutive duplicates, and the times (s) of passing them at constant speed.

    Fewer than two points remain if the path has no length.
    """
    kept = list(points[:1])
    kept += [here for before, here in pairwise(points) if math.dist(before, here) > 1e-12]
    gone = [0.0]
    for before, here in pairwise(kept):
        gone.append(gone[-1] + math.dist(before, here))
    return tuple(kept), tuple(duration * way / gone[-1] if gone[-1] else 0.0 for way in gone)


def aligned_points(points: Sequence[Vector]) -> tuple[tuple[Vector, ...], tuple[float, ...]]:
    """Return the points without consecutive duplicates, and the heading change (rad) at each for an aligned object.

    The heading changes evenly along curves. At a corner it takes the shorter turn, within SHARE of the adjacent legs.
    """
    kept = [points[0], *(here for before, here in pairwise(points) if math.dist(before, here) > 1e-12)]
    leads = _headings(kept)
    line, turns = [kept[0]], [leads[0]]
    for before, here, after, (first, second) in zip(kept, kept[1:], kept[2:], pairwise(leads), strict=False):
        if abs(second - first) <= MIN_CORNER_ANGLE:
            line.append(here)
            turns.append((first + second) / 2)
        else:
            line += [_toward(here, before, CORNER_SHARE), _toward(here, after, CORNER_SHARE)]
            turns += [first, second]
    if len(leads) > 1 and abs(leads[1] - leads[0]) <= MIN_CORNER_ANGLE:  # curves turn from end to end
        turns[0] -= (leads[1] - leads[0]) / 2
    last = (leads[-1] - leads[-2]) / 2 if len(leads) > 1 and abs(leads[-1] - leads[-2]) <= MIN_CORNER_ANGLE else 0.0
    return (*line, kept[-1]), tuple(turn - turns[0] for turn in (*turns, leads[-1] + last))


def _headings(points: Sequence[Vector]) -> list[float]:
    """Return the unwrapped heading (rad) of each leg; a vertical leg keeps the previous heading."""
    headings: list[float] = []
    for (x, y, _), (to_x, to_y, _) in pairwise(points):
        level = math.hypot(to_x - x, to_y - y) > 1e-12
        before = headings[-1] if headings else 0.0
        lead = math.atan2(to_y - y, to_x - x) if level else before
        headings.append(before + math.remainder(lead - before, 2 * math.pi) if headings else lead)
    return headings


def _toward(here: Vector, there: Vector, share: float) -> Vector:
    """Return the point at a share of the way between two points."""
    return add(scale(1 - share, here), scale(share, there))


def _polygon(sides: int, length: float) -> tuple[Vector, ...]:
    """Return a regular polygon traversed to the left, from the middle of a side and back."""
    points = [ORIGIN, (length / 2, 0.0, 0.0)]
    for i in range(1, sides):
        angle = 2 * math.pi * i / sides
        points.append(add(points[-1], (length * math.cos(angle), length * math.sin(angle), 0.0)))
    return (*points, ORIGIN)


def _arc(length: float, width: float) -> tuple[Vector, ...]:
    """Return an arc, by the sagitta formula: radius = (length² / 4 + width²) / (2 width)."""
    radius = (length * length / 4 + width * width) / (2 * width)
    half = math.atan2(length / 2, radius - width)
    points = _around((length / 2, width - radius, 0.0), radius, math.pi / 2 + half, math.pi / 2 - half)
    return (ORIGIN, *points[1:-1], (length, 0.0, 0.0))


def _around(middle: Vector, radius: float, start: float, stop: float) -> tuple[Vector, ...]:
    count = 2 * max(4, math.ceil(CIRCLE_SEGMENTS / 2 * abs(stop - start) / (2 * math.pi)))  # even
    angles = (start + (stop - start) * i / count for i in range(count + 1))
    points = (add(middle, scale(radius, (math.cos(a), math.sin(a), 0.0))) for a in angles)
    first, *rest = points
    return (ORIGIN if math.hypot(*first) < 1e-9 else first, *rest)


_FORMS: dict[str, Callable[[float, float], tuple[Vector, ...]]] = {
    "straight": lambda length, _: (ORIGIN, (length, 0.0, 0.0)),
    "arc": _arc,
    "zigzag": lambda length, width: tuple((length * i / 4, width * (i % 2), 0.0) for i in range(5)),
    "circle": lambda length, _: (*_around((length / 2, 0.0, 0.0), length / 2, math.pi, 3 * math.pi)[:-1], ORIGIN),
    "back_and_forth": lambda length, _: (ORIGIN, (length, 0.0, 0.0), ORIGIN),
    "square": lambda length, _: _polygon(4, length),
    "triangle": lambda length, _: _polygon(3, length),
}
