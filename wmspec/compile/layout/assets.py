"""Assets: objects that are joined to one another as their file says, and placed as one.

An asset's frame is what its base is placed by. With all joints at 0 each link is where its `at` and turn say, seen from
there, and each joint where its `at` and `axis` say. A joint that starts elsewhere takes with it all links beyond.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from wmspec.compile.layout import geometry
from wmspec.compile.layout.solids import Piece
from wmspec.core.diagnostics import ImpossibleValue
from wmspec.core.space import HERE, Pose, Vector, about, times, turn, unit
from wmspec.lang.check.ir.ir import Thing
from wmspec.lang.check.types import units

if TYPE_CHECKING:
    from wmspec.compile.layout.values import Values

#: A joint may start so far (rad, m) beyond a limit.
_ROUNDING = 1e-9


def base(values: Values, owner: str) -> str | None:
    """The base of the asset that an object is a link of, itself if it is that; None if it is of no asset."""
    if owner in values.assets:
        return owner
    return next((of for of, members in values.assets.items() if any(t.name == owner for t in members)), None)


def links(values: Values, owner: str) -> tuple[str, ...]:
    """The links of the asset whose base this is, the base first; the object alone if it is of none."""
    return owner, *(t.name for t in values.assets.get(owner, ()) if t.kind == "object")


def within(values: Values, owner: str) -> Pose:
    """Where a link of an asset is at the start, seen from the asset's frame."""
    return values.once((owner, "within"), lambda: _shift(values, owner).then(at_zero(values, owner)))


def at_zero(values: Values, owner: str) -> Pose:
    """Where a link of an asset would be with all joints at 0, seen from the asset's frame; what is of none is there."""
    if owner in values.assets:
        return HERE
    return Pose(values.vector(owner, "at"), turn(*geometry.own_turn(values, owner)))


def pieces(values: Values, owner: str) -> tuple[Piece, ...]:
    """The solids of an object, with those of all links if it is the base of an asset, seen from its frame."""
    if owner not in values.assets:
        return geometry.pieces(values, owner)
    placed = ((within(values, link), geometry.pieces(values, link)) for link in links(values, owner))
    return tuple(Piece(piece.solid, here.then(piece.pose)) for here, made in placed for piece in made)


def _shift(values: Values, owner: str) -> Pose:
    """What the joints from the asset's frame to a link, where they start, do to all that is beyond them."""
    of = base(values, owner) or owner
    holders = values.once((of, "holders"), lambda: _holders(values, of))
    shift, link = HERE, owner
    for _ in holders:  # at most through all of them
        if link not in holders:
            break
        joint = holders[link]
        shift = _moved(values, joint).then(shift)
        link = values.reference(joint.name, "to") if values.has(joint.name, "to") else ""
    return shift


def _holders(values: Values, of: str) -> dict[str, Thing]:
    """The joint that holds each link of an asset, but for those that nothing holds."""
    return {values.reference(t.name, "of"): t for t in values.assets.get(of, ()) if t.kind == "joint"}


def _moved(values: Values, joint: Thing) -> Pose:
    """What a joint does to all that is beyond it, where it starts, seen from the asset's frame."""
    if joint.model not in ("hinge", "slider"):
        return HERE
    start = values.number(joint.name, "start") if values.has(joint.name, "start") else 0.0
    within_limits(values, joint, start)
    axis: Vector = unit(values.vector(joint.name, "axis"))
    if joint.model == "slider":
        return Pose(times(start, axis))
    middle = values.vector(joint.name, "at")
    there = Pose(middle, about(axis, start))
    return there.then(Pose(times(-1.0, middle)))


def within_limits(values: Values, thing: Thing, start: float, help: str = "") -> None:
    """Raise ImpossibleValue, with a remedy, if a hinge or slider starts beyond its limits."""
    joint, model = thing.name, thing.model
    if (end := beyond(values, joint, start)) is not None:
        place = values.place(joint, "start" if values.has(joint, "start") else end)
        limit = told(values.number(joint, end), model)
        raise ImpossibleValue(f"`{joint}` starts at {told(start, model)}, beyond its limit of {limit}", place, help)


def beyond(values: Values, joint: str, coordinate: float) -> str | None:
    """Which limit of a hinge or slider, `low` or `high`, a coordinate (rad or m) is beyond; None if it is within."""
    for end, sign in (("low", 1.0), ("high", -1.0)):
        if values.has(joint, end) and sign * (coordinate - values.number(joint, end)) < -_ROUNDING:
            return end
    return None


def told(coordinate: float, model: str) -> str:
    """The coordinate (rad or m) of a hinge or slider, as messages tell it."""
    return units.told(coordinate, units.ANGLE if model == "hinge" else units.LENGTH)
