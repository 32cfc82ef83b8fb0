"""Objects that are inside one another at the start, and how deep."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import combinations
from typing import TYPE_CHECKING

from wmspec.compile.layout.geometry import pieces
from wmspec.compile.layout.solids import Piece, bounds
from wmspec.compile.layout.values import Values
from wmspec.core.space import Vector, add, cross, rotate, times
from wmspec.sim.shapes import Shape

if TYPE_CHECKING:  # most scenes need no more than the axes, and checking those should not wait for numpy
    from wmspec.sim.scene import model

#: So deep (m) objects may be in one another: less is a matter of rounding, and of resting on a curved thing.
SLACK = 1e-3

#: Axes of a solid along which it may be apart from another: those of its edges.
_EDGES: tuple[Vector, ...] = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


@dataclass(frozen=True)
class Overlap:
    """Two objects and how deep (m) one is in the other: the diameter of the largest ball within both."""

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


def separation(values: Values, a: str, b: str) -> tuple[float, Vector]:
    """How far (m) two objects are apart, negative where they overlap, and the way on which they are nearest."""
    first, second = (_pieces_of(values, name) for name in (a, b))
    pairs = [(p, q) for p in first for q in second]
    return min((max((-_overlap(p, q, d), d) for d in _directions(p, q)) for p, q in pairs))


def _pieces_of(values: Values, name: str) -> tuple[Piece, ...]:
    """The convex pieces of an object in the world."""
    pose = values.pose(name)
    return tuple(
        Piece(convex, pose.then(piece.pose).then(at))
        for piece in pieces(values, name)
        for convex, at in piece.solid.pieces()
    )


def _bodies(values: Values) -> Iterator[_Body]:
    for thing in values.spec.things:
        name = thing.name
        if thing.kind != "object" or not values.there(name) or not values.flag(name, "solid"):
            continue
        if any(_in_pieces(values, part) for part in (name, *values.parts(name))):
            continue
        box = bounds(pieces(values, name), values.pose(name))
        yield _Body(name, values.flag(name, "fixed"), _pieces_of(values, name), *box)


def _in_pieces(values: Values, part: str) -> bool:
    return values.has(part, "file") and values.text(part, "collision") == "pieces"


def _joined(values: Values) -> set[frozenset[str]]:
    joints = [t.name for t in values.spec.things if t.kind == "joint" and values.there(t.name)]
    return {frozenset(values.ends(j)) for j in joints if values.has(j, "to")}


# ---------------------------------------------------------------- how deep


def _depth(a: Piece, b: Piece) -> float:
    """The diameter (m) of the largest ball within two convex pieces, or 0 if it is less than SLACK.

    Two convex bodies are apart if there is a direction along which they are. For boxes one of a few is it; those are
    tried first, because what it takes to be exact is slow to import.
    """
    if any(_overlap(a, b, d) <= SLACK for d in _directions(a, b)):
        return 0.0
    from wmspec.sim.scene.physics.overlap import overlap

    (first, at), (second, there) = _placed(a), _placed(b)
    return overlap(first, at, second, there, SLACK)


def _overlap(a: Piece, b: Piece, d: Vector) -> float:
    """How far (m) `a` reaches beyond where `b` begins, along a unit vector."""
    return a.reach(d) + b.reach(times(-1.0, d))


def _directions(a: Piece, b: Piece) -> Iterator[Vector]:
    """Both ways along the axes on which two boxes can be apart, and along the line between the middles.

    A box's are the axes of either and those at right angles to an edge of each (Gottschalk, Lin & Manocha, "OBBTree",
    1996).
    """
    own = [rotate(a.pose.orientation, axis) for axis in _EDGES]
    others = [rotate(b.pose.orientation, axis) for axis in _EDGES]
    faces = [rotate(p.pose.orientation, normal) for p in (a, b) for normal, _ in p.solid.flats]
    between = add(b.pose.position, times(-1.0, a.pose.position))
    for axis in (*own, *others, *faces, *(cross(x, y) for x in own for y in others), between):
        size = math.hypot(*axis)
        if size > 1e-6:
            yield times(1 / size, axis)
            yield times(-1 / size, axis)


def _placed(piece: Piece) -> tuple[Shape, model.Pose]:
    """A convex piece, and where it is as a scene says it."""
    import numpy as np

    from wmspec.sim.scene import model

    return piece.solid, model.Pose(np.array(piece.pose.position), np.array(piece.pose.orientation))
