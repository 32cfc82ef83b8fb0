"""Path planning of walkers: around obstacles, to a goal object."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from heapq import heappop, heappush

from wmspec.compile.robots.ground_path import PathSegment, Pivot, Pose2D, Straight
from wmspec.compile.robots.obstacles import Outline, Point, clearance

CELL = 0.1  # m: of the grid
ARRIVAL_DISTANCE = 0.35  # m: of a walker from its goal
MAX_CELLS = 60_000
_AROUND = tuple((i, j) for i in (-1, 0, 1) for j in (-1, 0, 1) if i or j)


def path_to(
    spot: Pose2D, goal: Sequence[Outline], standing: Sequence[Outline], keeps: float
) -> list[PathSegment] | None:
    """Return a path that stays `keeps` (m) clear of obstacles, comes near the goal and faces it.

    None if there is no such path.
    """
    cells = _grid_path(spot, goal, standing, keeps)
    if cells is None:
        return None
    legs, here = list[PathSegment](), spot
    for corner in _shortcut(cells, standing, keeps):
        legs += [Pivot(here, _turn_to(here, corner)), Straight(here, 0.0)]
        here = legs[-2].at(legs[-2].length)
        legs[-1] = Straight(here, math.dist((here.x, here.y), corner))
        here = legs[-1].at(legs[-1].length)
    nearest = min(goal, key=lambda outline: outline.distance((here.x, here.y)))
    return [*legs, Pivot(here, _turn_to(here, nearest.middle))]


def _turn_to(here: Pose2D, point: Point) -> float:
    """Return the turn (rad) from a pose towards a point."""
    return math.remainder(math.atan2(point[1] - here.y, point[0] - here.x) - here.heading, math.tau)


def _grid_path(spot: Pose2D, goal: Sequence[Outline], standing: Sequence[Outline], keeps: float) -> list[Point] | None:
    """Return a shortest path on a grid (P. Hart, N. Nilsson and B. Raphael's A*, 1968)."""
    blocked = _blocked(standing, keeps)
    middle = math.fsum(o.middle[0] for o in goal) / len(goal), math.fsum(o.middle[1] for o in goal) / len(goal)
    reach = max(math.dist(o.middle, middle) + o.radius for o in goal)

    def at(cell: tuple[int, int]) -> Point:
        return spot.x + CELL * cell[0], spot.y + CELL * cell[1]

    def left(cell: tuple[int, int]) -> float:
        return max(0.0, math.dist(at(cell), middle) - reach)

    def there(cell: tuple[int, int]) -> bool:
        return left(cell) <= near and clearance(goal, at(cell)) <= near and _is_in_sight(at(cell), goal, standing)

    near = keeps + ARRIVAL_DISTANCE
    known: dict[tuple[int, int], tuple[float, tuple[int, int] | None]] = {(0, 0): (0.0, None)}
    waiting = [(left((0, 0)), (0, 0))]
    done = set[tuple[int, int]]()
    while waiting and len(done) < MAX_CELLS:
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
    """Return a predicate for points closer than `keeps` (m) to an obstacle; only nearby obstacles are tested."""
    around: dict[tuple[int, int], list[Outline]] = {}

    def blocked(point: Point) -> bool:
        square = (math.floor(point[0]), math.floor(point[1]))
        if square not in around:
            middle = (square[0] + 0.5, square[1] + 0.5)
            around[square] = [o for o in standing if math.dist(o.middle, middle) < o.radius + keeps + 1]
        return any(math.dist(o.middle, point) < o.radius + keeps and o.distance(point) < keeps for o in around[square])

    return blocked


def _shortcut(way: Sequence[Point], standing: Sequence[Outline], keeps: float) -> list[Point]:
    """Return the corners of the path after removing points that a straight line can skip."""
    corners, i = list[Point](), 0
    while i < len(way) - 1:
        ahead = (k for k in range(len(way) - 1, i + 1, -1) if _is_clear(way[i], way[k], standing, keeps - CELL / 10))
        i = next(ahead, i + 1)
        corners.append(way[i])
    return corners


def _is_clear(a: Point, b: Point, standing: Sequence[Outline], keeps: float) -> bool:
    """Whether a line stays clear of obstacles; each step is as long as the clearance permits."""
    length, far = math.dist(a, b), 0.0
    middle = ((a[0] + b[0]) / 2, (a[1] + b[1]) / 2)
    near = [o for o in standing if math.dist(o.middle, middle) < o.radius + length / 2 + keeps]
    while far < length:
        share = far / length
        here = (a[0] + share * (b[0] - a[0]), a[1] + share * (b[1] - a[1]))
        spare = clearance(near, here) - keeps
        if spare < 0:
            return False
        far += max(spare, CELL / 20)
    return True


def _is_in_sight(point: Point, goal: Sequence[Outline], standing: Sequence[Outline]) -> bool:
    """Whether no obstacle is between a point and the goal."""
    name = goal[0].name
    nearest = min(goal, key=lambda outline: outline.distance(point))
    steps = max(1, math.ceil(math.dist(point, nearest.middle) / (CELL / 2)))
    for k in range(steps + 1):
        share = k / steps
        here = (point[0] + share * (nearest.middle[0] - point[0]), point[1] + share * (nearest.middle[1] - point[1]))
        if nearest.contains(here):
            return True
        if any(outline.name != name and outline.contains(here) for outline in standing):
            return False
    return True
