"""Plane outlines: integrals, validity, convex decomposition.

An outline is a tuple of points; the last is joined to the first. `checked_outline` makes it counter-clockwise.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from functools import lru_cache
from itertools import pairwise

from wmspec.sim.shapes.shape import UnfitError

Point = tuple[float, float]
Outline = tuple[Point, ...]

CONVEX_SLACK = 0.01
"""Excess area of a convex part, relative to the whole outline."""

_NODES = ((0.5 - math.sqrt(0.15), 5 / 18), (0.5, 8 / 18), (0.5 + math.sqrt(0.15), 5 / 18))
"""Gauss-Legendre nodes: exact for polynomials up to degree five."""


def checked_outline(points: Sequence[Point], name: str) -> Outline:
    """Return the outline counter-clockwise.

    Raises UnfitError about the property `name` if it is degenerate or crosses itself.
    """
    outline = tuple(b for a, b in zip((points[-1], *points), points, strict=False) if a != b) if points else ()
    if len(outline) < 3:
        raise UnfitError(f"needs three points or more in its {name}", name)
    if _crosses(outline):
        raise UnfitError(f"has a {name} that crosses or touches itself", name)
    return outline if _area(outline) > 0 else outline[::-1]


def integral(outline: Outline, of: Callable[[float, float], float]) -> float:
    """Return the integral over the outline of the derivative of `of` by its first argument, up to degree four.

    By Green's theorem this is the contour integral of `of`.
    """
    total = 0.0
    for (x, y), (u, v) in _edges(outline):
        total += (v - y) * sum(weight * of(x + t * (u - x), y + t * (v - y)) for t, weight in _NODES)
    return total


def triangles(outline: Outline) -> list[tuple[int, int, int]]:
    """Return a triangulation by ear clipping (Meisters, "Polygons have ears", 1975)."""
    left, ears = list(range(len(outline))), []
    while len(left) > 3:
        ear = next((i for i in range(len(left)) if _ear(outline, left, i)), 0)
        ears.append((left[ear - 1], left[ear], left[(ear + 1) % len(left)]))
        del left[ear]
    return [*ears, (left[0], left[1], left[2])]


@lru_cache(maxsize=256)
def convex(outline: Outline) -> tuple[Outline, ...]:
    """Return few convex parts that cover the outline: triangles merged while (almost) convex.

    Hertel and Mehlhorn, "Fast triangulation of simple polygons", 1983.
    """
    pieces = [list(one) for one in triangles(outline)]
    spare = CONVEX_SLACK * _area(outline)
    i = 0
    while i < len(pieces):
        for j in range(i + 1, len(pieces)):
            joined = _joined(pieces[i], pieces[j])
            if joined and (whole := _convex(outline, joined, spare)):
                pieces[i] = whole
                del pieces[j]
                i = -1
                break
        i += 1
    return tuple(tuple(outline[k] for k in piece) for piece in pieces)


def smooth_runs(outline: Sequence[Point], crease: float) -> Iterator[list[tuple[Point, Point]]]:
    """Yield points with outward unit normals in runs of edges that bend by less than `crease` (rad).

    A closed run ends with its first point.
    """
    edges = list(_edges(outline))
    count = len(edges)
    normals = [((v - y) / math.hypot(u - x, v - y), (x - u) / math.hypot(u - x, v - y)) for (x, y), (u, v) in edges]
    sharp = [i for i in range(count) if _dot(normals[i - 1], normals[i]) < math.cos(crease)]

    def between(i: int) -> tuple[Point, Point]:
        return edges[i % count][0], _mean(normals[(i - 1) % count], normals[i % count])

    if not sharp:
        yield [between(i) for i in range(count + 1)]
    for first, last in pairwise([*sharp, *(i + count for i in sharp[:1])]):
        ends = (edges[first][0], normals[first]), (edges[last % count][0], normals[(last - 1) % count])
        yield [ends[0], *map(between, range(first + 1, last)), ends[1]]


def _edges(outline: Sequence[Point]) -> Iterator[tuple[Point, Point]]:
    return zip(outline, (*outline[1:], outline[0]), strict=True)


def _area(outline: Sequence[Point]) -> float:
    return sum(x * v - u * y for (x, y), (u, v) in _edges(outline)) / 2


def _turn(a: Point, b: Point, c: Point) -> float:
    """Return twice the signed area of a triangle, positive if counter-clockwise."""
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])


def _dot(a: Point, b: Point) -> float:
    return a[0] * b[0] + a[1] * b[1]


def _mean(a: Point, b: Point) -> Point:
    x, y = a[0] + b[0], a[1] + b[1]
    return (x / math.hypot(x, y), y / math.hypot(x, y))


def _crosses(outline: Outline) -> bool:
    edges = list(_edges(outline))
    for i, (a, b) in enumerate(edges):
        for j in range(i + 1, len(edges)):
            c, d = edges[j]
            if b == c or d == a:
                if _turn(a, b, d if b == c else c) == 0 and _dot(_from(a, b), _from(c, d)) < 0:
                    return True
            elif _turn(a, b, c) * _turn(a, b, d) <= 0 and _turn(c, d, a) * _turn(c, d, b) <= 0 and _near(a, b, c, d):
                return True
    return False


def _from(a: Point, b: Point) -> Point:
    return (b[0] - a[0], b[1] - a[1])


def _near(a: Point, b: Point, c: Point, d: Point) -> bool:
    """Whether the bounding boxes of two edges intersect."""
    return all(max(min(a[i], b[i]), min(c[i], d[i])) <= min(max(a[i], b[i]), max(c[i], d[i])) for i in (0, 1))


def _ear(outline: Outline, left: Sequence[int], i: int) -> bool:
    corner = (left[i - 1], left[i], left[(i + 1) % len(left)])
    a, b, c = (outline[k] for k in corner)
    if _turn(a, b, c) <= 0:
        return False
    others = (outline[k] for k in left if k not in corner)
    return not any(_turn(a, b, p) >= 0 and _turn(b, c, p) >= 0 and _turn(c, a, p) >= 0 for p in others)


def _joined(a: Sequence[int], b: Sequence[int]) -> list[int] | None:
    """Return the union of two parts that share an edge, else None."""
    for i, k in enumerate(a):
        following = a[(i + 1) % len(a)]
        for j, m in enumerate(b):
            if m == following and b[(j + 1) % len(b)] == k:
                around = [*a[i + 1 :], *a[: i + 1]]
                return [*around, *[b[(j + 2 + n) % len(b)] for n in range(len(b) - 2)]]
    return None


def _convex(outline: Outline, piece: Sequence[int], spare: float) -> list[int] | None:
    """Return a part without its reflex points if that adds at most `spare` (m²), else None."""
    kept, added = list(piece), 0.0
    i = 0
    while i < len(kept):
        turn = _turn(*(outline[kept[(i + k) % len(kept)]] for k in (-1, 0, 1)))
        if turn < -1e-12 * spare:
            added -= turn / 2
            if added > spare or len(kept) == 3:
                return None
            del kept[i]
            i = max(i - 2, -1)
        i += 1
    return kept
