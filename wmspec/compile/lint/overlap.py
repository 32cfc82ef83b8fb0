"""Initial overlaps of objects, and their depths."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import combinations
from typing import TYPE_CHECKING

from wmspec.compile.layout.evaluator import Evaluator
from wmspec.compile.layout.geometry import pieces
from wmspec.compile.layout.solids import PlacedShape, bounds
from wmspec.core.space import Vector, add, cross, rotate, scale
from wmspec.sim.shapes import Shape

if TYPE_CHECKING:  # imported late: most scenes need the axes only, and importing numpy slows their check
    from wmspec.sim.scene import model

#: Permitted initial overlap (m), for rounding and for contact with curved surfaces. Engines eject bodies with a deeper
#: one, each in another way.
MAX_OVERLAP = 1e-3

#: Separating axes of a solid: the directions of its edges.
_EDGES: tuple[Vector, ...] = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


@dataclass(frozen=True)
class Overlap:
    """Two overlapping objects and the depth (m): the diameter of the largest ball within both."""

    first: str
    second: str
    depth: float


@dataclass(frozen=True)
class _Body:
    """A placed object: its convex pieces in the world, and their axis-aligned box."""

    name: str
    fixed: bool
    pieces: tuple[PlacedShape, ...]
    low: Vector
    high: Vector


def overlaps(values: Evaluator) -> Iterator[Overlap]:
    """Yield pairs of overlapping objects, unless both are fixed or a joint connects them.

    Meshes with convex decomposition are omitted, since their pieces depend on the engine.
    """
    joined = _joined_pairs(values)
    for a, b in combinations(_bodies(values), 2):
        apart = any(a.low[i] >= b.high[i] - MAX_OVERLAP or b.low[i] >= a.high[i] - MAX_OVERLAP for i in range(3))
        if apart or (a.fixed and b.fixed) or frozenset((a.name, b.name)) in joined:
            continue
        depth = max(_depth(p, q) for p in a.pieces for q in b.pieces)
        if depth > MAX_OVERLAP:
            yield Overlap(a.name, b.name, depth)


def separation(values: Evaluator, a: str, b: str) -> tuple[float, Vector]:
    """Return the distance (m) of two objects, negative for overlaps, and the direction of closest approach."""
    first, second = (_pieces_of(values, name) for name in (a, b))
    pairs = [(p, q) for p in first for q in second]
    return min((max((-_overlap(p, q, d), d) for d in _directions(p, q)) for p, q in pairs))


def may_be_within(values: Evaluator, a: str, b: str, distance: float) -> bool:
    """Whether the `separation` of two objects may be at most a positive distance (m); quick to compute."""
    spare = _radius(values, a) + _radius(values, b) + distance
    return math.dist(values.pose(a).position, values.pose(b).position) <= spare


def _radius(values: Evaluator, name: str) -> float:
    """Return the radius (m) of a ball about an object's origin that contains balls about its convex pieces."""
    return values.memoized((name, "radius of its pieces"), lambda: _radius_of_pieces(values, name))


def _radius_of_pieces(values: Evaluator, name: str) -> float:
    origin = values.pose(name).position
    return max(
        math.dist(origin, piece.pose.position)
        + math.hypot(*(max(piece.solid.reach(axis), piece.solid.reach(scale(-1.0, axis))) for axis in _EDGES))
        for piece in _pieces_of(values, name)
    )


def _pieces_of(values: Evaluator, name: str) -> tuple[PlacedShape, ...]:
    """Return the convex pieces of an object in the world."""
    return values.memoized((name, "convex pieces"), lambda: _convex_pieces(values, name))


def _convex_pieces(values: Evaluator, name: str) -> tuple[PlacedShape, ...]:
    pose = values.pose(name)
    return tuple(
        PlacedShape(convex, pose.compose(piece.pose).compose(at))
        for piece in pieces(values, name)
        for convex, at in piece.solid.pieces
    )


def _bodies(values: Evaluator) -> Iterator[_Body]:
    for thing in values.spec.things:
        name = thing.name
        if thing.kind != "object" or not values.is_present(name) or not values.flag(name, "solid"):
            continue
        if any(_is_decomposed(values, part) for part in (name, *values.parts(name))):
            continue
        box = bounds(pieces(values, name), values.pose(name))
        yield _Body(name, values.flag(name, "fixed"), _pieces_of(values, name), *box)


def _is_decomposed(values: Evaluator, part: str) -> bool:
    return values.has(part, "file") and values.text(part, "collision") == "pieces"


def _joined_pairs(values: Evaluator) -> set[frozenset[str]]:
    joints = [t.name for t in values.spec.things if t.kind == "joint" and values.is_present(t.name)]
    return {frozenset(values.ends(j)) for j in joints if values.has(j, "to")}


# ---------------------------------------------------------------- how deep


def _depth(a: PlacedShape, b: PlacedShape) -> float:
    """Return the diameter (m) of the largest ball within two convex pieces, or 0 if it is less than MAX_OVERLAP.

    Two convex bodies are disjoint if they are separated along some direction. For boxes a few axes suffice. These are
    tried first, because the exact method is slow to import.
    """
    if any(_overlap(a, b, d) <= MAX_OVERLAP for d in _directions(a, b)):
        return 0.0
    from wmspec.sim.scene.physics.overlap import overlap

    (first, at), (second, there) = _placed_piece(a), _placed_piece(b)
    return overlap(first, at, second, there, MAX_OVERLAP)


def _overlap(a: PlacedShape, b: PlacedShape, d: Vector) -> float:
    """Return how far (m) `a` extends beyond the start of `b` along a unit vector."""
    return a.reach(d) + b.reach(scale(-1.0, d))


def _directions(a: PlacedShape, b: PlacedShape) -> Iterator[Vector]:
    """Yield both directions of the separating axes of two boxes, and of the line between their centres.

    The axes of boxes are those of either and the cross products of their edges (Gottschalk, Lin & Manocha, "OBBTree",
    1996).
    """
    own = [rotate(a.pose.orientation, axis) for axis in _EDGES]
    others = [rotate(b.pose.orientation, axis) for axis in _EDGES]
    faces = [rotate(p.pose.orientation, normal) for p in (a, b) for normal, _ in p.solid.flat_faces]
    between = add(b.pose.position, scale(-1.0, a.pose.position))
    for axis in (*own, *others, *faces, *(cross(x, y) for x in own for y in others), between):
        size = math.hypot(*axis)
        if size > 1e-6:
            yield scale(1 / size, axis)
            yield scale(-1 / size, axis)


def _placed_piece(piece: PlacedShape) -> tuple[Shape, model.Pose]:
    """Return a convex piece, and its pose in a scene."""
    import numpy as np

    from wmspec.sim.scene import model

    return piece.solid, model.Pose(np.array(piece.pose.position), np.array(piece.pose.orientation))
