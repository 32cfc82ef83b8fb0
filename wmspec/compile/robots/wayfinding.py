"""The way of a walker to a thing: around all that stands there, and no nearer to it than it has to."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from heapq import heappop, heappush

from wmspec.compile.robots.obstacles import Outline, Point
from wmspec.compile.robots.ways import Leg, Pivot, Spot, Straight

CELL = 0.1  # m: how fine a way is looked for
WITHIN = 0.35  # m: so near before a thing a walker has come to it
MOST_CELLS = 60_000
_AROUND = tuple((i, j) for i in (-1, 0, 1) for j in (-1, 0, 1) if i or j)


def legs_to(spot: Spot, goal: Sequence[Outline], standing: Sequence[Outline], keeps: float) -> list[Leg] | None:
    """The legs of a way that `keeps` so far (m) from all that stands there and comes near the goal, and faces it.

    None if no way leads there.
    """
    cells = _cells(spot, goal, standing, keeps)
    if cells is None:
        return None
    legs, here = list[Leg](), spot
    for corner in _pulled(cells, standing, keeps):
        legs += [Pivot(here, _towards(here, corner)), Straight(here, 0.0)]
        here = legs[-2].at(legs[-2].length)
        legs[-1] = Straight(here, math.dist((here.x, here.y), corner))
        here = legs[-1].at(legs[-1].length)
    nearest = min(goal, key=lambda outline: outline.distance((here.x, here.y)))
    return [*legs, Pivot(here, _towards(here, nearest.middle))]


def _towards(here: Spot, point: Point) -> float:
    """By how much (rad) somebody turns to a point."""
    return math.remainder(math.atan2(point[1] - here.y, point[0] - here.x) - here.heading, math.tau)


def _cells(spot: Spot, goal: Sequence[Outline], standing: Sequence[Outline], keeps: float) -> list[Point] | None:
    """The points of a shortest way on a grid (P. Hart, N. Nilsson and B. Raphael's A*, 1968)."""
    blocked = _blocked(standing, keeps)
    middle = math.fsum(o.middle[0] for o in goal) / len(goal), math.fsum(o.middle[1] for o in goal) / len(goal)
    reach = max(math.dist(o.middle, middle) + o.radius for o in goal)

    def at(cell: tuple[int, int]) -> Point:
        return spot.x + CELL * cell[0], spot.y + CELL * cell[1]

    def left(cell: tuple[int, int]) -> float:
        return max(0.0, math.dist(at(cell), middle) - reach)

    def there(cell: tuple[int, int]) -> bool:
        return (
            left(cell) <= near and min(o.distance(at(cell)) for o in goal) <= near and _seen(at(cell), goal, standing)
        )

    near = keeps + WITHIN
    known: dict[tuple[int, int], tuple[float, tuple[int, int] | None]] = {(0, 0): (0.0, None)}
    waiting = [(left((0, 0)), (0, 0))]
    done = set[tuple[int, int]]()
    while waiting and len(done) < MOST_CELLS:
        _, cell = heappop(waiting)
        if cell in done:
            continue
        done.add(cell)
        if there(cell):
            way: list[Point] = []
            back: tuple[int, int] | None = cell
            while back is not None:
                way.insert(0, at(back))
                back = known[back][1]
            return way
        for i, j in _AROUND:
            other = (cell[0] + i, cell[1] + j)
            gone = known[cell][0] + CELL * math.hypot(i, j)
            if other not in done and gone < known.get(other, (math.inf, None))[0] - 1e-9 and not blocked(at(other)):
                known[other] = gone, cell
                heappush(waiting, (gone + left(other), other))
    return None


def _blocked(standing: Sequence[Outline], keeps: float) -> Callable[[Point], bool]:
    """Whether a point is nearer than that (m) to anything, of which only what is near is looked at."""
    around: dict[tuple[int, int], list[Outline]] = {}

    def blocked(point: Point) -> bool:
        square = (math.floor(point[0]), math.floor(point[1]))
        if square not in around:
            middle = (square[0] + 0.5, square[1] + 0.5)
            around[square] = [o for o in standing if math.dist(o.middle, middle) < o.radius + keeps + 1]
        return any(math.dist(o.middle, point) < o.radius + keeps and o.distance(point) < keeps for o in around[square])

    return blocked


def _pulled(way: Sequence[Point], standing: Sequence[Outline], keeps: float) -> list[Point]:
    """The corners of the way, pulled straight: from each on to the last that is straight ahead."""
    corners, i = list[Point](), 0
    while i < len(way) - 1:
        ahead = (k for k in range(len(way) - 1, i + 1, -1) if _clear(way[i], way[k], standing, keeps - CELL / 10))
        i = next(ahead, i + 1)
        corners.append(way[i])
    return corners


def _clear(a: Point, b: Point, standing: Sequence[Outline], keeps: float) -> bool:
    """Whether all between two points keeps so far (m) from everything: it is looked at as far on as nothing can be."""
    length, far = math.dist(a, b), 0.0
    middle = ((a[0] + b[0]) / 2, (a[1] + b[1]) / 2)
    near = [o for o in standing if math.dist(o.middle, middle) < o.radius + length / 2 + keeps]
    while far < length:
        share = far / length
        here = (a[0] + share * (b[0] - a[0]), a[1] + share * (b[1] - a[1]))
        spare = min((o.distance(here) for o in near), default=math.inf) - keeps
        if spare < 0:
            return False
        far += max(spare, CELL / 20)
    return True


def _seen(point: Point, goal: Sequence[Outline], standing: Sequence[Outline]) -> bool:
    """Whether nothing else stands between a point and the goal."""
    name = goal[0].name
    nearest = min(goal, key=lambda outline: outline.distance(point))
    steps = max(1, math.ceil(math.dist(point, nearest.middle) / (CELL / 2)))
    for k in range(steps + 1):
        share = k / steps
        here = (point[0] + share * (nearest.middle[0] - point[0]), point[1] + share * (nearest.middle[1] - point[1]))
        if nearest.distance(here) == 0:
            return True
        if any(outline.name != name and outline.distance(here) == 0 for outline in standing):
            return False
    return True
