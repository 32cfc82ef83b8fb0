"""What objects rest on: the flat faces of others, the top of their upright box, the floor of a hollow."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING, Final, TypeGuard

from wmspec.compile.layout.geometry import pieces
from wmspec.compile.layout.solids import Face, bounds, surface, upward
from wmspec.core.diagnostics import ImpossibleValue
from wmspec.core.space import UP, Vector, add, inverse, rotate, tilt, times

if TYPE_CHECKING:
    from wmspec.compile.layout.values import Values

#: What `left_of(...)` and the like give: a place on the ground of the world, `("place", x, y)`.
WORLD: Final = "place"
#: Where something is put: (x, y) on what holds it, (x, y, z) in the world, or a place on its ground.
Spot = tuple[float, float] | Vector | tuple[str, float, float]
#: Shapes that are hollow, or can be.
HOLLOW = ("tube", "lathe", "extrude")


def is_point(at: Spot) -> TypeGuard[tuple[float, float] | Vector]:
    """Whether a spot is a point, and no place on the ground of the world."""
    return at[0] != WORLD


def under(values: Values, owner: str, at: Spot) -> Face | None:
    """The point that an object rests on, as a face whose middle it is; None if it neither rests on nor in anything."""
    held = holder(values, owner)
    if held is None:
        return None
    if is_point(at) and len(at) == 3:
        raise ImpossibleValue(f"`{owner}` rests on something, so its place there is (x, y)", values.place(owner, "at"))
    way, base = held
    if way == "inside" and not values.parts(base):
        place = values.place(owner, "inside")
        shape = values.text(base, "shape")
        hollow = shape in HOLLOW and not values.has(base, "file")
        remedy = f"put its shape into a part: `part wall {{ shape: {shape} ... }}`" if hollow else f"use `on: {base}`"
        raise ImpossibleValue(f"`{base}` has no parts, so nothing can be inside it", place, remedy)
    return bottom(values, base, at) if way == "inside" else top(values, base, at)


def holder(values: Values, owner: str) -> tuple[str, str] | None:
    """What an object rests `on` or `inside`, and which of the two; None if on nothing."""
    holders = [(way, values.reference(owner, way)) for way in ("on", "inside") if values.has(owner, way)]
    if len(holders) == 2:
        raise ImpossibleValue(f"`{owner}` is both `on` and `inside`", values.place(owner, "inside"), "keep one of them")
    if holders and holders[0][1] == owner:
        raise ImpossibleValue(f"`{owner}` cannot rest on itself", values.place(owner, holders[0][0]))
    return holders[0] if holders else None


# ---------------------------------------------------------------- on top


def tops(values: Values, base: str) -> list[Face]:
    """The surfaces on which things can rest on an object, the most level one first."""
    return values.once((base, "tops"), lambda: _tops(values, base))


def _tops(values: Values, base: str) -> list[Face]:
    here, made = values.pose(base), pieces(values, base)
    if len(made) == 1 and made[0].solid.flats:
        placed = here.then(made[0].pose)
        return list(upward(made[0].solid, placed, values.number(base, "yaw")))
    highest = bounds(made, here)[1][2]
    return [Face((here.position[0], here.position[1], highest), UP, values.number(base, "yaw"))]


def top(values: Values, base: str, at: Spot) -> Face:
    """The point at `at` on top of an object: from the middle of the face that looks up most, or in the world."""
    faces = tops(values, base)
    if is_point(at):
        return Face(add(faces[0].middle, _along(faces[0], at[0], at[1])), faces[0].normal)
    x, y = at[-2:]
    lid = min(faces, key=lambda face: face.height(x, y))
    return Face((x, y, lid.height(x, y)), lid.normal)


def _along(face: Face, x: float, y: float) -> Vector:
    cos, sin = math.cos(face.yaw), math.sin(face.yaw)
    return rotate(tilt(face.normal), (cos * x - sin * y, sin * x + cos * y, 0.0))


def seen_from(face: Face, at: Spot) -> tuple[float, float]:
    """A place as (x, y) from the middle of a face, along its own axes."""
    if is_point(at):
        return (at[0], at[1])
    x, y = at[-2:]
    away = add((x, y, face.height(x, y)), times(-1.0, face.middle))
    level = rotate(inverse(tilt(face.normal)), away)
    cos, sin = math.cos(face.yaw), math.sin(face.yaw)
    return (cos * level[0] + sin * level[1], cos * level[1] - sin * level[0])


# ---------------------------------------------------------------- inside


def bottom(values: Values, base: str, at: Spot) -> Face:
    """The point at `at` in the hollow of a compound object: on its lowest part there, or on what that stands on."""
    x, y = _ground(values, base, at)
    floor = min(_floors(values, base, x, y), key=lambda face: face.height(x, y), default=None)
    face = floor or _below(values, base, x, y)
    return Face((x, y, face.height(x, y)), face.normal)


def _ground(values: Values, base: str, at: Spot) -> tuple[float, float]:
    if not is_point(at):
        return at[-2:]
    x, y, _ = values.pose(base).apply((at[0], at[1], 0.0))
    return (x, y)


def _floors(values: Values, base: str, x: float, y: float) -> Iterator[Face]:
    for piece in pieces(values, base):
        face = surface(piece.solid, values.pose(base).then(piece.pose), x, y)
        if face is not None:
            yield face


def _below(values: Values, base: str, x: float, y: float) -> Face:
    """What a container stands on; the level of its lowest point if it stands on nothing."""
    face = under(values, base, (WORLD, x, y))
    return face or Face((x, y, bounds(pieces(values, base), values.pose(base))[0][2]))
