"""Placed shapes of an object: their extents, and their flat faces that face upwards."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import product

from wmspec.core.space import IDENTITY, UP, Pose, Quaternion, Vector, dot, inverse, multiply, rotate, scale
from wmspec.sim.shapes import Shape
from wmspec.sim.shapes.shape import AXES

#: The lowest and the highest corner (m) of an axis-aligned box.
Box = tuple[Vector, Vector]


@dataclass(frozen=True)
class PlacedShape:
    """A shape with its pose in the object's frame."""

    solid: Shape
    pose: Pose

    def reach(self, direction: Vector) -> float:
        """Return the support distance (m) along a unit vector of the object's frame."""
        own = self.solid.reach(rotate(inverse(self.pose.orientation), direction))
        return dot(direction, self.pose.position) + own


def reach(pieces: Iterable[PlacedShape], direction: Vector) -> float:
    """Return the support distance (m) of an object along a unit vector of its own frame."""
    return max(piece.reach(direction) for piece in pieces)


def bounds(pieces: Sequence[PlacedShape], pose: Pose) -> Box:
    """Return the axis-aligned bounding box (m) of an object, in the frame in which `pose` is given."""
    here, back = pose.position, inverse(pose.orientation)
    low = [here[i] - reach(pieces, rotate(back, scale(-1.0, axis))) for i, axis in enumerate(AXES)]
    high = [here[i] + reach(pieces, rotate(back, axis)) for i, axis in enumerate(AXES)]
    return (low[0], low[1], low[2]), (high[0], high[1], high[2])


def corners(box: Box) -> Iterator[Vector]:
    """Yield the eight corners of a box."""
    (a, b, c), (x, y, z) = box
    yield from product((a, x), (b, y), (c, z))


def footprint(pieces: Iterable[PlacedShape], own: Quaternion) -> float:
    """Return the radius (m) of a vertical cylinder about the origin that contains an object rotated by `own`."""
    return max(_footprint(piece, own) for piece in pieces)


def _footprint(piece: PlacedShape, own: Quaternion) -> float:
    x, y, _ = rotate(own, piece.pose.position)
    turned = multiply(own, piece.pose.orientation)
    symmetry = piece.solid.symmetry
    if symmetry == "ball" or (symmetry == "axis" and turned[1] == turned[2] == 0):
        return math.hypot(x, y) + piece.solid.reach(AXES[0])
    along = (max(piece.solid.reach(rotate(inverse(turned), scale(s, a))) for s in (-1.0, 1.0)) for a in AXES[:2])
    return math.hypot(x, y) + math.hypot(*along)


@dataclass(frozen=True)
class Face:
    """A flat supporting surface: centre, unit normal, and the heading (rad) of its x axis."""

    middle: Vector
    normal: Vector = UP
    yaw: float = 0.0

    def height(self, x: float, y: float) -> float:
        """Return the height (m) of the surface at (x, y)."""
        if self.normal[2] >= 1:
            return self.middle[2]
        rise = self.normal[0] * (x - self.middle[0]) + self.normal[1] * (y - self.middle[1])
        return self.middle[2] - rise / self.normal[2]


def upward_faces(solid: Shape, pose: Pose, yaw: float = 0.0) -> Iterator[Face]:
    """Yield the upward faces of a placed solid, the most level first."""
    faces = []
    for normal, offset in solid.flat_faces:
        turned = rotate(pose.orientation, normal)
        if turned[2] > 1e-9:
            faces.append(Face(pose.apply(scale(offset, normal)), turned, yaw))
    yield from sorted(faces, key=lambda face: -face.normal[2])


def surface_at(solid: Shape, pose: Pose, x: float, y: float) -> Face | None:
    """Return the upward face of a placed solid at (x, y), or None if the solid does not cover it.

    Solids with curved faces count as their axis-aligned bounding box, unless they are hollow and upright.
    """
    if solid.hollow and rotate(pose.orientation, UP)[2] > 1 - 1e-9:
        own = pose.inverse_apply((x, y, pose.position[2]))
        height = solid.floor(own[0], own[1])
        return None if height is None else Face((x, y, pose.position[2] + height))
    if not solid.flat_faces:
        low, high = bounds((PlacedShape(solid, IDENTITY),), pose)
        held = low[0] <= x <= high[0] and low[1] <= y <= high[1]
        return Face((x, y, high[2])) if held else None
    floor, lid = -math.inf, None
    for normal, offset in solid.flat_faces:
        turned = rotate(pose.orientation, normal)
        face = Face(pose.apply(scale(offset, normal)), turned)
        if abs(turned[2]) <= 1e-9:
            if turned[0] * (x - face.middle[0]) + turned[1] * (y - face.middle[1]) > 1e-9:
                return None
        elif turned[2] < 0:
            floor = max(floor, face.height(x, y))
        elif lid is None or face.height(x, y) < lid.height(x, y):
            lid = face
    return lid if lid is not None and floor <= lid.height(x, y) + 1e-9 else None
