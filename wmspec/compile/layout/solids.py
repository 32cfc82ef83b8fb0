"""Shapes where they are in an object: how far they reach together, and which of their flat faces look up."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import product

from wmspec.core.space import HERE, UP, Pose, Quaternion, Vector, dot, inverse, multiply, rotate, times
from wmspec.sim.shapes import Shape
from wmspec.sim.shapes.shape import AXES

#: The lowest and the highest corner (m) of an upright box.
Box = tuple[Vector, Vector]


@dataclass(frozen=True)
class Piece:
    """A shape and where it is in the frame of its object."""

    solid: Shape
    pose: Pose

    def reach(self, direction: Vector) -> float:
        """How far (m) it goes from the object's origin along a unit vector of the object's frame."""
        own = self.solid.reach(rotate(inverse(self.pose.orientation), direction))
        return dot(direction, self.pose.position) + own


def reach(pieces: Iterable[Piece], direction: Vector) -> float:
    """How far (m) an object goes from its origin along a unit vector of its own frame."""
    return max(piece.reach(direction) for piece in pieces)


def bounds(pieces: Sequence[Piece], pose: Pose) -> Box:
    """The lowest and the highest corner (m) of the upright box around an object, in the frame of `pose`."""
    here, back = pose.position, inverse(pose.orientation)
    low = [here[i] - reach(pieces, rotate(back, times(-1.0, axis))) for i, axis in enumerate(AXES)]
    high = [here[i] + reach(pieces, rotate(back, axis)) for i, axis in enumerate(AXES)]
    return (low[0], low[1], low[2]), (high[0], high[1], high[2])


def corners(box: Box) -> Iterator[Vector]:
    """All eight of a box."""
    (a, b, c), (x, y, z) = box
    yield from product((a, x), (b, y), (c, z))


def footprint(pieces: Iterable[Piece], own: Quaternion) -> float:
    """The radius (m) of an upright cylinder around the origin that holds an object turned by `own`."""
    return max(_footprint(piece, own) for piece in pieces)


def _footprint(piece: Piece, own: Quaternion) -> float:
    x, y, _ = rotate(own, piece.pose.position)
    turned = multiply(own, piece.pose.orientation)
    symmetry = piece.solid.symmetry
    if symmetry == "ball" or (symmetry == "axis" and turned[1] == turned[2] == 0):
        return math.hypot(x, y) + piece.solid.reach(AXES[0])
    along = (max(piece.solid.reach(rotate(inverse(turned), times(s, a))) for s in (-1.0, 1.0)) for a in AXES[:2])
    return math.hypot(x, y) + math.hypot(*along)


@dataclass(frozen=True)
class Face:
    """A flat surface that things can rest on: its middle, its unit normal, and the heading (rad) of its own x axis."""

    middle: Vector
    normal: Vector = UP
    yaw: float = 0.0

    def height(self, x: float, y: float) -> float:
        """How high (m) it is at a place."""
        if self.normal[2] >= 1:
            return self.middle[2]
        rise = self.normal[0] * (x - self.middle[0]) + self.normal[1] * (y - self.middle[1])
        return self.middle[2] - rise / self.normal[2]


def upward(solid: Shape, pose: Pose, yaw: float = 0.0) -> Iterator[Face]:
    """The faces of a placed solid that look up, the most level one first."""
    faces = []
    for normal, offset in solid.flats:
        turned = rotate(pose.orientation, normal)
        if turned[2] > 1e-9:
            faces.append(Face(pose.apply(times(offset, normal)), turned, yaw))
    yield from sorted(faces, key=lambda face: -face.normal[2])


def surface(solid: Shape, pose: Pose, x: float, y: float) -> Face | None:
    """The upward face of a placed solid at a place, or None if the solid is not below or above the place.

    What has other than flat faces counts as the upright box around it, unless it is hollow and upright.
    """
    if solid.hollow and rotate(pose.orientation, UP)[2] > 1 - 1e-9:
        own = pose.seen((x, y, pose.position[2]))
        height = solid.floor(own[0], own[1])
        return None if height is None else Face((x, y, pose.position[2] + height))
    if not solid.flats:
        low, high = bounds((Piece(solid, HERE),), pose)
        held = low[0] <= x <= high[0] and low[1] <= y <= high[1]
        return Face((x, y, high[2])) if held else None
    floor, lid = -math.inf, None
    for normal, offset in solid.flats:
        turned = rotate(pose.orientation, normal)
        face = Face(pose.apply(times(offset, normal)), turned)
        if abs(turned[2]) <= 1e-9:
            if turned[0] * (x - face.middle[0]) + turned[1] * (y - face.middle[1]) > 1e-9:
                return None
        elif turned[2] < 0:
            floor = max(floor, face.height(x, y))
        elif lid is None or face.height(x, y) < lid.height(x, y):
            lid = face
    return lid if lid is not None and floor <= lid.height(x, y) + 1e-9 else None
