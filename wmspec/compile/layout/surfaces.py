"""Supporting surfaces: flat faces, the top of a bounding box, the floor of a cavity."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING, Final, TypeGuard

from wmspec.compile.layout.geometry import pieces
from wmspec.compile.layout.solids import Face, bounds, surface_at, upward_faces
from wmspec.core.diagnostics import ImpossibleValue
from wmspec.core.space import UP, Vector, add, align_z, inverse, rotate, scale

if TYPE_CHECKING:
    from wmspec.compile.layout.evaluator import Evaluator

#: Tag of the value of `left_of(...)` and similar functions: `("place", x, y)` on the world's ground.
WORLD: Final = "place"
#: A position: (x, y) on the support, (x, y, z) in the world, or a place on the world's ground.
Spot = tuple[float, float] | Vector | tuple[str, float, float]
#: Shapes that are, or can be, hollow.
HOLLOW = ("tube", "lathe", "extrude")


def is_point(at: Spot) -> TypeGuard[tuple[float, float] | Vector]:
    """Whether a position is a point rather than a place on the world's ground."""
    return at[0] != WORLD


def contact_face(values: Evaluator, owner: str, at: Spot) -> Face | None:
    """Return the contact point below an object as a face centred there; None without a support or container."""
    held = support_of(values, owner)
    if held is None:
        return None
    if is_point(at) and len(at) == 3:
        raise ImpossibleValue(
            f"`{owner}` rests on something, so its place there is (x, y)", values.source_location(owner, "at")
        )
    way, base = held
    if way == "inside" and not values.parts(base):
        place = values.source_location(owner, "inside")
        shape = values.text(base, "shape")
        hollow = shape in HOLLOW and not values.has(base, "file")
        remedy = f"put its shape into a part: `part wall {{ shape: {shape} ... }}`" if hollow else f"use `on: {base}`"
        raise ImpossibleValue(f"`{base}` has no parts, so nothing can be inside it", place, remedy)
    return floor_point(values, base, at) if way == "inside" else top_point(values, base, at)


def support_of(values: Evaluator, owner: str) -> tuple[str, str] | None:
    """Return the support or container of an object and the property (`on` or `inside`) that names it, or None."""
    holders = [(way, values.reference(owner, way)) for way in ("on", "inside") if values.has(owner, way)]
    if len(holders) == 2:
        raise ImpossibleValue(
            f"`{owner}` is both `on` and `inside`", values.source_location(owner, "inside"), "keep one of them"
        )
    if holders and holders[0][1] == owner:
        raise ImpossibleValue(f"`{owner}` cannot rest on itself", values.source_location(owner, holders[0][0]))
    return holders[0] if holders else None


# ---------------------------------------------------------------- on top


def support_faces(values: Evaluator, base: str) -> list[Face]:
    """Return the surfaces of an object that can support others, the most level first."""
    return values.memoized((base, "tops"), lambda: _tops(values, base))


def _tops(values: Evaluator, base: str) -> list[Face]:
    here, made = values.pose(base), pieces(values, base)
    if len(made) == 1 and made[0].solid.flat_faces:
        placed = here.compose(made[0].pose)
        return list(upward_faces(made[0].solid, placed, values.number(base, "yaw")))
    highest = bounds(made, here)[1][2]
    return [Face((here.position[0], here.position[1], highest), UP, values.number(base, "yaw"))]


def top_point(values: Evaluator, base: str, at: Spot) -> Face:
    """Return the point `at` on top of an object, relative to the centre of its most level face, or in the world."""
    faces = support_faces(values, base)
    if is_point(at):
        return Face(add(faces[0].middle, _along(faces[0], at[0], at[1])), faces[0].normal)
    x, y = at[-2:]
    lid = min(faces, key=lambda face: face.height(x, y))
    return Face((x, y, lid.height(x, y)), lid.normal)


def _along(face: Face, x: float, y: float) -> Vector:
    cos, sin = math.cos(face.yaw), math.sin(face.yaw)
    return rotate(align_z(face.normal), (cos * x - sin * y, sin * x + cos * y, 0.0))


def face_coordinates(face: Face, at: Spot) -> tuple[float, float]:
    """Return a place as (x, y) relative to the centre of a face, along its own axes."""
    if is_point(at):
        return (at[0], at[1])
    x, y = at[-2:]
    away = add((x, y, face.height(x, y)), scale(-1.0, face.middle))
    level = rotate(inverse(align_z(face.normal)), away)
    cos, sin = math.cos(face.yaw), math.sin(face.yaw)
    return (cos * level[0] + sin * level[1], cos * level[1] - sin * level[0])


# ---------------------------------------------------------------- inside


def floor_point(values: Evaluator, base: str, at: Spot) -> Face:
    """Return the point `at` in the cavity of a compound object: on its lowest part there, or on its support."""
    x, y = _ground(values, base, at)
    floor = min(_floors(values, base, x, y), key=lambda face: face.height(x, y), default=None)
    face = floor or _below(values, base, x, y)
    return Face((x, y, face.height(x, y)), face.normal)


def _ground(values: Evaluator, base: str, at: Spot) -> tuple[float, float]:
    if not is_point(at):
        return at[-2:]
    x, y, _ = values.pose(base).apply((at[0], at[1], 0.0))
    return (x, y)


def _floors(values: Evaluator, base: str, x: float, y: float) -> Iterator[Face]:
    for piece in pieces(values, base):
        face = surface_at(piece.solid, values.pose(base).compose(piece.pose), x, y)
        if face is not None:
            yield face


def _below(values: Evaluator, base: str, x: float, y: float) -> Face:
    """Return the support of a container, or the level of its lowest point if it has none."""
    face = contact_face(values, base, (WORLD, x, y))
    return face or Face((x, y, bounds(pieces(values, base), values.pose(base))[0][2]))
