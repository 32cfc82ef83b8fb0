"""The shapes of the language as solids: how far they reach, their flat faces, their volume."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Protocol

from wmspec.check.vocabulary import ROUND
from wmspec.space import HERE, UP, Pose, Quaternion, Vector, dot, inverse, multiply, rotate, times, unit

#: How thick (m) the slab below a plane is.
SLAB = 0.1
_AXES: tuple[Vector, ...] = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), UP)


class Hull(Protocol):
    """What is asked of a mesh: the volume (m³) of its convex hull, and how far (m) that reaches."""

    @property
    def volume(self) -> float:
        """How much room it takes."""
        ...

    def reach(self, direction: Vector) -> float:
        """The largest component (m) of its points along a direction."""
        ...


@dataclass(frozen=True)
class Solid:
    """A shape with the edges (m) of the upright box around it, in its own frame; `hull` is that of a mesh."""

    kind: str
    edges: Vector
    hull: Hull | None = None

    def reach(self, direction: Vector) -> float:
        """How far (m) it goes from its origin along a unit vector: its support function."""
        return _mesh(self.hull, direction) if self.hull else _REACH[self.kind](self.edges, direction)

    @property
    def volume(self) -> float:
        """How much room it takes, m³."""
        x, y, z = self.edges
        return self.hull.volume if self.hull else _VOLUMES[self.kind](x, y, z)

    @property
    def faces(self) -> tuple[tuple[Vector, float], ...]:
        """The planes of a solid with flat faces only: outward unit normals and how far (m) they are from its origin."""
        return _faces(self.kind, *self.edges)


@dataclass(frozen=True)
class Piece:
    """A solid and where it is in the frame of its object."""

    solid: Solid
    pose: Pose

    def reach(self, direction: Vector) -> float:
        """How far (m) it goes from the object's origin along a unit vector of the object's frame."""
        own = self.solid.reach(rotate(inverse(self.pose.orientation), direction))
        return dot(direction, self.pose.position) + own


def reach(pieces: Iterable[Piece], direction: Vector) -> float:
    """How far (m) an object goes from its origin along a unit vector of its own frame."""
    return max(piece.reach(direction) for piece in pieces)


def bounds(pieces: Sequence[Piece], pose: Pose) -> tuple[Vector, Vector]:
    """The lowest and the highest corner (m) of the upright box around an object, in the frame of `pose`."""
    here, back = pose.position, inverse(pose.orientation)
    low = [here[i] - reach(pieces, rotate(back, times(-1.0, axis))) for i, axis in enumerate(_AXES)]
    high = [here[i] + reach(pieces, rotate(back, axis)) for i, axis in enumerate(_AXES)]
    return (low[0], low[1], low[2]), (high[0], high[1], high[2])


def footprint(pieces: Iterable[Piece], own: Quaternion) -> float:
    """The radius (m) of an upright cylinder around the origin that holds an object turned by `own`."""
    return max(_footprint(piece, own) for piece in pieces)


def _footprint(piece: Piece, own: Quaternion) -> float:
    x, y, _ = rotate(own, piece.pose.position)
    turned = multiply(own, piece.pose.orientation)
    if piece.solid.kind == "sphere" or (piece.solid.kind in ROUND and turned[1] == turned[2] == 0):
        return math.hypot(x, y) + piece.solid.edges[0] / 2
    along = (max(piece.solid.reach(rotate(inverse(turned), times(s, a))) for s in (-1.0, 1.0)) for a in _AXES[:2])
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


def upward(solid: Solid, pose: Pose, yaw: float = 0.0) -> Iterator[Face]:
    """The faces of a placed solid that look up, the most level one first."""
    found = []
    for normal, offset in solid.faces:
        turned = rotate(pose.orientation, normal)
        if turned[2] > 1e-9:
            found.append(Face(pose.apply(times(offset, normal)), turned, yaw))
    yield from sorted(found, key=lambda face: -face.normal[2])


def surface(solid: Solid, pose: Pose, x: float, y: float) -> Face | None:
    """The upward face of a placed solid at a place, or None if the solid is not below or above the place.

    What has other than flat faces counts as the upright box around it.
    """
    if not solid.faces:
        low, high = bounds((Piece(solid, HERE),), pose)
        held = low[0] <= x <= high[0] and low[1] <= y <= high[1]
        return Face((x, y, high[2])) if held else None
    floor, lid = -math.inf, None
    for normal, offset in solid.faces:
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


# ---------------------------------------------------------------- support functions


def _box(edges: Vector, d: Vector) -> float:
    return (abs(d[0]) * edges[0] + abs(d[1]) * edges[1] + abs(d[2]) * edges[2]) / 2


def _plane(edges: Vector, d: Vector) -> float:
    return (abs(d[0]) * edges[0] + abs(d[1]) * edges[1]) / 2 + max(0.0, -d[2] * SLAB)


def _sphere(edges: Vector, d: Vector) -> float:
    return math.hypot(*d) * edges[0] / 2


def _cylinder(edges: Vector, d: Vector) -> float:
    return (math.hypot(d[0], d[1]) * edges[0] + abs(d[2]) * edges[2]) / 2


def _cone(edges: Vector, d: Vector) -> float:
    return max(d[2] * edges[2], math.hypot(d[0], d[1]) * edges[0] - d[2] * edges[2]) / 2


def _capsule(edges: Vector, d: Vector) -> float:
    return (math.hypot(*d) * edges[0] + abs(d[2]) * (edges[2] - edges[0])) / 2


def _wedge(edges: Vector, d: Vector) -> float:
    """Of its three corners, or rather edges along y: the two at its foot and the upper one at -x."""
    x, z = d[0] * edges[0], d[2] * edges[2]
    return (max(abs(x) - z, z - x) + abs(d[1]) * edges[1]) / 2


def _mesh(hull: Hull, d: Vector) -> float:
    return hull.reach(d)


_REACH: dict[str, Callable[[Vector, Vector], float]] = {
    "box": _box,
    "cube": _box,
    "plane": _plane,
    "sphere": _sphere,
    "cylinder": _cylinder,
    "cone": _cone,
    "capsule": _capsule,
    "wedge": _wedge,
}

_VOLUMES: dict[str, Callable[[float, float, float], float]] = {
    "box": lambda x, y, z: x * y * z,
    "cube": lambda x, y, z: x * y * z,
    "plane": lambda x, y, _: x * y * SLAB,
    "sphere": lambda x, _, __: math.pi / 6 * x * x * x,
    "cylinder": lambda x, _, z: math.pi / 4 * x * x * z,
    "cone": lambda x, _, z: math.pi / 12 * x * x * z,
    "capsule": lambda x, _, z: math.pi / 4 * x * x * (z - x) + math.pi / 6 * x * x * x,
    "wedge": lambda x, y, z: x * y * z / 2,
}


def _faces(kind: str, x: float, y: float, z: float) -> tuple[tuple[Vector, float], ...]:
    sides = (((0.0, 1.0, 0.0), y / 2), ((0.0, -1.0, 0.0), y / 2), ((-1.0, 0.0, 0.0), x / 2))
    right = ((1.0, 0.0, 0.0), x / 2)
    match kind:
        case "box" | "cube":
            return ((UP, z / 2), ((0.0, 0.0, -1.0), z / 2), *sides, right)
        case "plane":
            return ((UP, 0.0), ((0.0, 0.0, -1.0), SLAB), *sides, right)
        case "wedge":
            return ((unit((z, 0.0, x)), 0.0), ((0.0, 0.0, -1.0), z / 2), *sides)
        case _:
            return ()
