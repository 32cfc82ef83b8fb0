"""Objects that are inside one another at the start, and how deep."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import combinations

from wmspec.design.forms import pieces
from wmspec.design.solids import Piece, bounds
from wmspec.design.space import Vector, add, cross, rotate, times
from wmspec.design.values import Values

#: So deep (m) objects may be in one another: less is a matter of rounding, and of resting on a curved thing.
SLACK = 1e-3

#: Axes of a solid along which it may be apart from another: those of its edges.
_EDGES: tuple[Vector, ...] = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


@dataclass(frozen=True)
class Overlap:
    """Two objects and how deep (m) one is in the other: so far one would have to move to be outside."""

    first: str
    second: str
    depth: float


@dataclass(frozen=True)
class _Body:
    """An object in its place: its convex pieces in the world, and the upright box around it."""

    name: str
    fixed: bool
    pieces: tuple[Piece, ...]
    low: Vector
    high: Vector


def overlaps(values: Values) -> Iterator[Overlap]:
    """Pairs of objects that are inside one another, unless both are fixed or a joint connects them.

    Meshes that are touched in several convex pieces are left out: how they are cut is the engine's business.
    """
    joined = _joined(values)
    for a, b in combinations(_bodies(values), 2):
        apart = any(a.low[i] >= b.high[i] - SLACK or b.low[i] >= a.high[i] - SLACK for i in range(3))
        if apart or (a.fixed and b.fixed) or frozenset((a.name, b.name)) in joined:
            continue
        depth = max(_depth(p, q) for p in a.pieces for q in b.pieces)
        if depth > SLACK:
            yield Overlap(a.name, b.name, depth)


def _bodies(values: Values) -> Iterator[_Body]:
    for thing in values.spec.things:
        name = thing.name
        if thing.kind != "object" or not values.there(name) or not values.property(name, "solid"):
            continue
        if any(_in_pieces(values, part) for part in (name, *values.parts(name))):
            continue
        made, pose = pieces(values, name), values.pose(name)
        placed = tuple(Piece(piece.solid, pose.then(piece.pose)) for piece in made)
        yield _Body(name, values.property(name, "fixed"), placed, *bounds(made, pose))


def _in_pieces(values: Values, part: str) -> bool:
    return values.has(part, "file") and bool(values.property(part, "collision") == "pieces")


def _joined(values: Values) -> set[frozenset[str]]:
    joints = [t.name for t in values.spec.things if t.kind == "joint"]
    return {frozenset((values.property(j, "of"), values.property(j, "to"))) for j in joints if values.has(j, "to")}


# ---------------------------------------------------------------- how deep


def _depth(a: Piece, b: Piece) -> float:
    """How far (m) a convex piece is in another; less than 0 if it is outside.

    Two convex bodies are apart if there is a direction along which they are, and the depth is the least overlap of all
    directions. For boxes one of these is it: an axis of either, or at right angles to an edge of each (Gottschalk,
    Lin & Manocha, "OBBTree", 1996). For round bodies the best of those, and of the line between the middles, is
    improved by a search, unless it shows already that they are apart.
    """
    best, direction = min((_overlap(a, b, d), d) for d in _directions(a, b))
    step = 0.25
    while best > SLACK and step > 1e-3:
        better, found = min((_overlap(a, b, d), d) for d in _around(direction, step))
        if better < best:
            best, direction = better, found
        else:
            step /= 2
    return best


def _overlap(a: Piece, b: Piece, d: Vector) -> float:
    """How far (m) `a` reaches beyond where `b` begins, along a unit vector."""
    return a.reach(d) + b.reach(times(-1.0, d))


def _directions(a: Piece, b: Piece) -> Iterator[Vector]:
    """Both ways along the axes on which two boxes can be apart, and along the line between the middles."""
    own = [rotate(a.pose.orientation, axis) for axis in _EDGES]
    others = [rotate(b.pose.orientation, axis) for axis in _EDGES]
    faces = [rotate(p.pose.orientation, normal) for p in (a, b) for normal, _ in p.solid.faces]
    between = add(b.pose.position, times(-1.0, a.pose.position))
    for axis in (*own, *others, *faces, *(cross(x, y) for x in own for y in others), between):
        size = math.hypot(*axis)
        if size > 1e-6:
            yield times(1 / size, axis)
            yield times(-1 / size, axis)


def _around(direction: Vector, step: float) -> Iterator[Vector]:
    """Unit vectors about `step` (rad) from a direction, all around it."""
    x, y, z = direction
    aside = cross(direction, (0.0, 0.0, 1.0) if abs(z) < 0.9 else (1.0, 0.0, 0.0))
    aside = times(1 / math.hypot(*aside), aside)
    across = cross(direction, aside)
    for i in range(8):
        angle = math.pi / 4 * i
        tilted = add((x, y, z), add(times(step * math.cos(angle), aside), times(step * math.sin(angle), across)))
        yield times(1 / math.hypot(*tilted), tilted)
