"""Ways that objects are carried along: forms by name, or given points, turned and walked at constant speed."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from itertools import pairwise

from wmspec.core.space import ORIGIN, Vector, add, times

#: A bend that is sharper than this (rad) is a corner, which is turned within this share of the legs around it.
CORNER, SHARE = math.radians(30), 0.1

#: Into how many straight pieces a full circle is cut: at 40 cm across they stray 0.1 mm from it.
PIECES = 96


def named(form: str, length: float, width: float) -> tuple[Vector, ...]:
    """The points (m) of a form of path that sets out from the origin along +x, and strays to +y.

    straight: to (length, 0). arc: a part of a circle to the same end that bulges by `width`. zigzag: to the same end by
    four legs that stray by `width`. circle: around, through (length, 0). back_and_forth: to (length, 0) and back again.
    square, triangle: around, to the left, with sides of that length, from the middle of one of them.
    """
    return _FORMS[form](length, width)


def turned(points: Sequence[Sequence[float]], angle: float) -> tuple[Vector, ...]:
    """Points (x, y) or (x, y, z) turned about the vertical, the origin first."""
    cos, sin = math.cos(angle), math.sin(angle)
    around = tuple((cos * x - sin * y, sin * x + cos * y, z[0] if z else 0.0) for x, y, *z in points)
    return around if around and around[0] == ORIGIN else (ORIGIN, *around)


def walked(points: Sequence[Vector], duration: float) -> tuple[tuple[Vector, ...], tuple[float, ...]]:
    """The points, none twice in a row, and the times (s) at which something as fast everywhere is there.

    Fewer than two points are left if the way has no length.
    """
    kept = list(points[:1])
    kept += [here for before, here in pairwise(points) if math.dist(before, here) > 1e-12]
    gone = [0.0]
    for before, here in pairwise(kept):
        gone.append(gone[-1] + math.dist(before, here))
    return tuple(kept), tuple(duration * way / gone[-1] if gone[-1] else 0.0 for way in gone)


def faced(points: Sequence[Vector]) -> tuple[tuple[Vector, ...], tuple[float, ...]]:
    """The points of a path, none twice in a row, and how far (rad) what turns with it has turned at each.

    Along a curve it turns evenly. At a corner it turns by the shorter way, while it goes around it.
    """
    kept = [points[0], *(here for before, here in pairwise(points) if math.dist(before, here) > 1e-12)]
    leads = _headings(kept)
    line, turns = [kept[0]], [leads[0]]
    for before, here, after, (first, second) in zip(kept, kept[1:], kept[2:], pairwise(leads), strict=False):
        if abs(second - first) <= CORNER:
            line.append(here)
            turns.append((first + second) / 2)
        else:
            line += [_toward(here, before, SHARE), _toward(here, after, SHARE)]
            turns += [first, second]
    if len(leads) > 1 and abs(leads[1] - leads[0]) <= CORNER:  # a curve bends from its first point to its last
        turns[0] -= (leads[1] - leads[0]) / 2
    last = (leads[-1] - leads[-2]) / 2 if len(leads) > 1 and abs(leads[-1] - leads[-2]) <= CORNER else 0.0
    return (*line, kept[-1]), tuple(turn - turns[0] for turn in (*turns, leads[-1] + last))


def _headings(points: Sequence[Vector]) -> list[float]:
    """The heading (rad) of each leg, counted on from the first; one that goes straight up keeps that before it."""
    headings: list[float] = []
    for (x, y, _), (to_x, to_y, _) in pairwise(points):
        level = math.hypot(to_x - x, to_y - y) > 1e-12
        before = headings[-1] if headings else 0.0
        lead = math.atan2(to_y - y, to_x - x) if level else before
        headings.append(before + math.remainder(lead - before, 2 * math.pi) if headings else lead)
    return headings


def _toward(here: Vector, there: Vector, share: float) -> Vector:
    """The point so far on the way."""
    return add(times(1 - share, here), times(share, there))


def _straight(length: float, _width: float) -> tuple[Vector, ...]:
    return (ORIGIN, (length, 0.0, 0.0))


def _zigzag(length: float, width: float) -> tuple[Vector, ...]:
    return tuple((length * i / 4, width * (i % 2), 0.0) for i in range(5))


def _back_and_forth(length: float, _width: float) -> tuple[Vector, ...]:
    return (ORIGIN, (length, 0.0, 0.0), ORIGIN)


def _square(length: float, _width: float) -> tuple[Vector, ...]:
    return _polygon(4, length)


def _triangle(length: float, _width: float) -> tuple[Vector, ...]:
    return _polygon(3, length)


def _polygon(sides: int, length: float) -> tuple[Vector, ...]:
    """Around a regular polygon to the left, from the middle of a side and back there."""
    points = [ORIGIN, (length / 2, 0.0, 0.0)]
    for i in range(1, sides):
        angle = 2 * math.pi * i / sides
        points.append(add(points[-1], (length * math.cos(angle), length * math.sin(angle), 0.0)))
    return (*points, ORIGIN)


def _circle(length: float, _width: float) -> tuple[Vector, ...]:
    return (*_around((length / 2, 0.0, 0.0), length / 2, math.pi, 3 * math.pi)[:-1], ORIGIN)


def _arc(length: float, width: float) -> tuple[Vector, ...]:
    """From the sagitta formula: radius = (length² / 4 + width²) / (2 width)."""
    radius = (length * length / 4 + width * width) / (2 * width)
    half = math.atan2(length / 2, radius - width)
    points = _around((length / 2, width - radius, 0.0), radius, math.pi / 2 + half, math.pi / 2 - half)
    return (ORIGIN, *points[1:-1], (length, 0.0, 0.0))


def _around(middle: Vector, radius: float, start: float, stop: float) -> tuple[Vector, ...]:
    count = 2 * max(4, math.ceil(PIECES / 2 * abs(stop - start) / (2 * math.pi)))  # even: half way is a point
    angles = (start + (stop - start) * i / count for i in range(count + 1))
    points = (add(middle, times(radius, (math.cos(a), math.sin(a), 0.0))) for a in angles)
    first, *rest = points
    return (ORIGIN if math.hypot(*first) < 1e-9 else first, *rest)


_FORMS: dict[str, Callable[[float, float], tuple[Vector, ...]]] = {
    "straight": _straight,
    "arc": _arc,
    "zigzag": _zigzag,
    "circle": _circle,
    "back_and_forth": _back_and_forth,
    "square": _square,
    "triangle": _triangle,
}
