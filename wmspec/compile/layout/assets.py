"""Assets: objects connected by joints as their file describes, placed as one.

The asset's frame is placed by its base. With all joints at 0, each link has the pose of its `at` and rotation in that
frame, and each joint has its `at` and `axis`. A joint with another start coordinate also moves all links beyond it.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from wmspec.compile.layout import geometry
from wmspec.compile.layout.solids import PlacedShape
from wmspec.core.diagnostics import ImpossibleValue
from wmspec.core.space import IDENTITY, Pose, Vector, from_axis_angle, from_ypr, scale, unit
from wmspec.lang.check.ir.ir import Entity
from wmspec.lang.check.types import units

if TYPE_CHECKING:
    from wmspec.compile.layout.evaluator import Evaluator

#: Tolerance (rad, m) for a joint that starts beyond a limit.
_ROUNDING = 1e-9


def base(values: Evaluator, owner: str) -> str | None:
    """Return the base of the asset that an object belongs to, itself if it is the base, or None."""
    if owner in values.assets:
        return owner
    return next((of for of, members in values.assets.items() if any(t.name == owner for t in members)), None)


def links(values: Evaluator, owner: str) -> tuple[str, ...]:
    """Return the links of the asset with this base, the base first; only the object if it is not in an asset."""
    return owner, *(t.name for t in values.assets.get(owner, ()) if t.kind == "object")


def pose_in_asset(values: Evaluator, owner: str) -> Pose:
    """Return the initial pose of a link in the asset's frame."""
    return values.memoized((owner, "within"), lambda: _joint_offset(values, owner).compose(zero_pose(values, owner)))


def zero_pose(values: Evaluator, owner: str) -> Pose:
    """Return the pose of a link in the asset's frame with all joints at 0; identity outside an asset."""
    if owner in values.assets:
        return IDENTITY
    return Pose(values.vector(owner, "at"), from_ypr(*geometry.own_rotation(values, owner)))


def pieces(values: Evaluator, owner: str) -> tuple[PlacedShape, ...]:
    """Return the solids of an object; for the base of an asset those of all links, in the asset's frame."""
    if owner not in values.assets:
        return geometry.pieces(values, owner)
    placed = ((pose_in_asset(values, link), geometry.pieces(values, link)) for link in links(values, owner))
    return tuple(PlacedShape(piece.solid, here.compose(piece.pose)) for here, made in placed for piece in made)


def _joint_offset(values: Evaluator, owner: str) -> Pose:
    """Return the motion of a link due to the start coordinates of the joints between it and the asset's frame."""
    of = base(values, owner) or owner
    holders = values.memoized((of, "holders"), lambda: _holders(values, of))
    shift, link = IDENTITY, owner
    for _ in holders:  # bounded, as joints may form a loop
        if link not in holders:
            break
        joint = holders[link]
        shift = _joint_motion(values, joint).compose(shift)
        link = values.reference(joint.name, "to") if values.has(joint.name, "to") else ""
    return shift


def _holders(values: Evaluator, of: str) -> dict[str, Entity]:
    """Return the joint that holds each link of an asset; unattached links are omitted."""
    return {values.reference(t.name, "of"): t for t in values.assets.get(of, ()) if t.kind == "joint"}


def _joint_motion(values: Evaluator, joint: Entity) -> Pose:
    """Return the motion of everything beyond a joint due to its start coordinate, in the asset's frame."""
    if joint.model not in ("hinge", "slider"):
        return IDENTITY
    start = values.number(joint.name, "start") if values.has(joint.name, "start") else 0.0
    require_within_limits(values, joint, start)
    axis: Vector = unit(values.vector(joint.name, "axis"))
    if joint.model == "slider":
        return Pose(scale(start, axis))
    middle = values.vector(joint.name, "at")
    there = Pose(middle, from_axis_angle(axis, start))
    return there.compose(Pose(scale(-1.0, middle)))


def require_within_limits(values: Evaluator, thing: Entity, start: float, help: str = "") -> None:
    """Raise ImpossibleValue, with a remedy, if a hinge or slider starts beyond its limits."""
    joint, model = thing.name, thing.model
    if (end := exceeded_limit(values, joint, start)) is not None:
        place = values.source_location(joint, "start" if values.has(joint, "start") else end)
        limit = format_coordinate(values.number(joint, end), model)
        raise ImpossibleValue(
            f"`{joint}` starts at {format_coordinate(start, model)}, beyond its limit of {limit}", place, help
        )


def exceeded_limit(values: Evaluator, joint: str, coordinate: float) -> str | None:
    """Return the limit of a hinge or slider, `low` or `high`, that a coordinate (rad or m) exceeds, or None."""
    for end, sign in (("low", 1.0), ("high", -1.0)):
        if values.has(joint, end) and sign * (coordinate - values.number(joint, end)) < -_ROUNDING:
            return end
    return None


def format_coordinate(coordinate: float, model: str) -> str:
    """Return the coordinate (rad or m) of a hinge or slider as text."""
    return units.format_quantity(coordinate, units.ANGLE if model == "hinge" else units.LENGTH)
