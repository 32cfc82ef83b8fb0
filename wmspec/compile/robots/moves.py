"""Planners of moving actions: `push`, `carry`, `rotate`, `tilt`, and `open` and `close` for joints."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from wmspec.compile.layout.motion import heading_of as heading
from wmspec.compile.robots.arm import Array, downward_pose, translation
from wmspec.compile.robots.grasps import FINGER_CLEARANCE, FIRM_POINTS, PALM_CLEARANCE, end_actions, grasp_pose
from wmspec.compile.robots.manipuland import Manipuland, joined_objects
from wmspec.compile.robots.planning import APPROACH_HEIGHT, OPEN_SPAN, PUSH_SPAN, Plan, PlanningError, require_single
from wmspec.compile.robots.tool_path import ToolSegment, rotation_matrix, smooth, stay, straight
from wmspec.core.diagnostics import ImpossibleValue
from wmspec.lang.check.ir.ir import Entity

PUSH_OPENING = 0.036  # m: distance of pushing fingers
MIN_OPEN_PUSH_WIDTH = 0.046  # m: narrower objects are pushed with closed fingers
APPROACH_DISTANCE = 0.04  # m: between the object and the hand that comes down beside it
CORNER_OFFSET = 0.05  # m: of each of two hands from the centre of its side
END_PUSH_DISTANCE = 0.035  # m: from the end of an object that turns
LIMIT_TOLERANCE = 1e-6  # rad or m: of a joint
UP = np.array([0.0, 0.0, 1.0])


def push(made: Plan, acts: Sequence[Entity], thing: Manipuland) -> Manipuland:
    """Plan to touch an object opposite to the direction of motion, and to push it.

    Two hands that push in the same or opposite directions each push one end. Two that push across each other move the
    object by the sum.
    """
    ways = {a.name: made.number(a, "distance") * heading_vector(made.values.direction(a.name)) for a in acts}
    asides = {a.name: np.zeros(3) for a in acts}
    total, turned = np.sum(list(ways.values()), axis=0), 0.0
    if len(acts) == 2:
        first, second = (way / np.linalg.norm(way) for way in ways.values())
        if abs(first @ second) > 0.99:
            asides, total, turned = _end_pushes(made, acts, thing, ways)
        else:
            asides = dict(
                zip(ways, (_corner_offset(thing, first, second), _corner_offset(thing, second, first)), strict=True)
            )
    rigid = translation(*total) @ rotation_about(thing.middle, UP, turned)
    for action in acts:
        _plan_push(made, action, thing, ways[action.name], asides[action.name], _push_motion(thing, total, turned))
    return thing.put(rigid)


def carry(made: Plan, acts: Sequence[Entity], thing: Manipuland) -> Manipuland:
    """Plan a horizontal motion of the hand with the held object."""
    action = require_single(acts)
    made.require_held(action)
    arm = made.arms[action.of]
    way = made.number(action, "distance") * heading_vector(made.values.direction(action.name))
    made.go(action, [ToolSegment(made.duration(action), straight(arm.tool, translation(*way) @ arm.tool), arm.width)])
    return thing.moved(way) if arm.held == thing.name else thing


def rotate(made: Plan, acts: Sequence[Entity], thing: Manipuland) -> Manipuland:
    """Plan a rotation of the hand with the held object about the vertical through the tool."""
    return _turn_hand(made, require_single(acts), thing, UP)


def tilt(made: Plan, acts: Sequence[Entity], thing: Manipuland) -> Manipuland:
    """Plan to tip the hand with the held object, as in pouring."""
    action = require_single(acts)
    return _turn_hand(made, action, thing, np.cross(UP, heading_vector(made.values.direction(action.name))))


def open_(made: Plan, acts: Sequence[Entity], thing: Manipuland) -> Manipuland:
    """Plan to grasp a handle, move it along its joint, release it and retract."""
    return _along_joint(made, require_single(acts), thing, 1.0)


def close(made: Plan, acts: Sequence[Entity], thing: Manipuland) -> Manipuland:
    """Plan the reverse of `open_`."""
    return _along_joint(made, require_single(acts), thing, -1.0)


# ---------------------------------------------------------------- steps


def heading_vector(direction: Any) -> Array:
    """Return the unit vector (3,) of a direction word or an angle."""
    angle = heading(direction)
    return np.array([np.cos(angle), np.sin(angle), 0.0])


def rotation_about(point: Array, axis: Array, angle: float) -> Array:
    """Return the rotation (4, 4) about an axis through a point."""
    turn = np.eye(4)
    turn[:3, :3] = rotation_matrix(angle * axis)
    return np.asarray(translation(*point) @ turn @ translation(*(-point)))


def _plan_push(
    made: Plan, action: Entity, thing: Manipuland, way: Array, aside: Array, move: Callable[[float], Array]
) -> None:
    """Plan one pushing hand: it comes down beside the object, follows its motion, and retracts."""
    arm, lasts = made.arms[action.of], made.duration(action)
    made.free(action)
    ahead = way / np.linalg.norm(way)
    face = made.nearest(action.of, (float(np.arctan2(ahead[1], ahead[0])),))
    z = max(thing.middle[2], thing.top - arm.arm.palm + PALM_CLEARANCE)
    gap = thing.reach(ahead) + arm.arm.width / 2
    apart = PUSH_OPENING if 2 * thing.reach(np.cross(UP, ahead)) > MIN_OPEN_PUSH_WIDTH else 0.0

    def beside(away: float) -> Array:
        x, y = thing.middle[:2] - ahead[:2] * (gap + away) + aside[:2]
        return downward_pose(x, y, z, face)

    first, near, touch = beside(APPROACH_DISTANCE), beside(0.001), beside(0.0)
    there = move(1.0) @ touch
    back = translation(*(-APPROACH_DISTANCE * (move(1.0)[:3, :3] @ ahead))) @ there
    above = translation(0.0, 0.0, APPROACH_HEIGHT)
    legs = [
        ToolSegment(0.28 * lasts, straight(arm.tool, above @ first), apart),
        ToolSegment(0.36 * lasts, straight(above @ first, first), apart),
        ToolSegment(0.41 * lasts, straight(first, near), apart),
        ToolSegment(PUSH_SPAN[0] * lasts, straight(near, touch), apart),
        ToolSegment(PUSH_SPAN[1] * lasts, lambda s: np.asarray(move(s) @ touch), apart),
        ToolSegment(0.65 * lasts, stay(there), apart),  # stops the spline from overshooting by 0.1 mm
        ToolSegment(0.695 * lasts, straight(there, back), apart),
        ToolSegment(0.762 * lasts, straight(back, above @ back), apart),
        ToolSegment(lasts, straight(above @ back, arm.retracted(back)), arm.arm.opening),
    ]
    made.go(action, legs)


def _push_motion(thing: Manipuland, total: Array, angle: float) -> Callable[[float], Array]:
    """Return the motion (4, 4) of a pushed object as a function of 0..1."""
    return lambda s: np.asarray(translation(*(s * total)) @ rotation_about(thing.middle, UP, s * angle))


def _end_pushes(
    made: Plan, acts: Sequence[Entity], thing: Manipuland, ways: dict[str, Array]
) -> tuple[dict[str, Array], Array, float]:
    """Return the contact offset of each hand, the displacement of the object, and its rotation (rad)."""
    sides, along = end_actions(made, acts, thing), thing.frame[:3, 0]
    across = np.cross(UP, along)
    arm = thing.half[0] - END_PUSH_DISTANCE
    if abs(ways[acts[0].name] @ along) > 1e-6:
        raise ImpossibleValue(
            f"two hands cannot push `{thing.name}` along its length", acts[1].place, "push it across, or round a corner"
        )
    gone = {side: float(ways[action.name] @ across) for side, action in sides.items()}
    if abs(gone[1] - gone[-1]) > 1.4 * arm:
        raise ImpossibleValue(f"`{thing.name}` would be turned too far", acts[0].place, "push less far")
    turned = float(np.arcsin((gone[1] - gone[-1]) / (2 * arm)))
    asides = {action.name: side * arm * along for side, action in sides.items()}
    return asides, (gone[1] + gone[-1]) / 2 * across, turned


def _corner_offset(thing: Manipuland, ahead: Array, other: Array) -> Array:
    """Return the offset of a hand from the centre of its side, away from the other hand at the corner."""
    across = other - (other @ ahead) * ahead
    return np.asarray(across * max(0.0, min(CORNER_OFFSET, thing.reach(other) - PUSH_OPENING / 2)))


def _turn_hand(made: Plan, action: Entity, thing: Manipuland, axis: Array) -> Manipuland:
    """Plan a rotation of the hand with the held object about an axis through the tool."""
    arm, angle = made.arms[action.of], made.number(action, "angle")
    here = arm.tool
    point = here[:3, 3]
    way = lambda s: np.asarray(rotation_about(point, axis, s * angle) @ here)  # noqa: E731
    made.require_held(action)
    try:
        made.go(action, [ToolSegment(made.duration(action), way, arm.width)])
    except PlanningError as unable:
        if unable.after is None:
            raise
        turned = abs(np.degrees(angle)) * smooth(unable.after / made.duration(action))
        reason = f"its joints stop after some {turned:.0f} of {abs(np.degrees(angle)):.0f} deg"
        raise PlanningError(action, reason, f"{action.verb} it less far, or the other way", unable.after) from None
    return thing.put(rotation_about(point, axis, angle)) if arm.held == thing.name else thing


def _along_joint(made: Plan, action: Entity, handle: Manipuland, sign: float) -> Manipuland:
    """Plan to grasp a handle, move it along its joint in the direction `sign`, release it and retract."""
    arm, lasts, joint = made.arms[action.of], made.duration(action), made.values.reference(action.name, "joint")
    made.free(action)
    by = sign * made.number(action, "far")
    _require_range(made, action, handle.name, joint, by)
    at, move = grasp_pose(made, action, handle), _joint_motion(made, action, joint, by)
    above, opened, closed = (
        translation(0.0, 0.0, APPROACH_HEIGHT),
        arm.arm.opening,
        handle.across(at) + FINGER_CLEARANCE,
    )
    there = move(1.0) @ at
    legs = [
        ToolSegment(0.24 * lasts, straight(arm.tool, above @ at), opened),
        ToolSegment(0.32 * lasts, straight(above @ at, at), opened),
        ToolSegment(OPEN_SPAN[0] * lasts, stay(at), closed),
        ToolSegment(OPEN_SPAN[1] * lasts, lambda s: np.asarray(move(s) @ at), closed),
        ToolSegment(0.70 * lasts, stay(there), opened),
        ToolSegment(0.77 * lasts, straight(there, above @ there), opened),
        ToolSegment(lasts, straight(above @ there, arm.retracted(there)), opened),
    ]
    made.go(action, legs)
    start = made.number(action, "start")
    made.hold(action, handle.name, start + OPEN_SPAN[0] * lasts, FIRM_POINTS)
    made.release(action, start + OPEN_SPAN[1] * lasts)
    made.opened[joint] = made.opened.get(joint, 0.0) + by
    return handle.put(move(1.0))


def _require_range(made: Plan, action: Entity, handle: str, joint: str, by: float) -> None:
    """Raise unless a joint holds the handle, or an object connected to it, and permits the motion (rad or m)."""
    values = made.values
    if values.reference(joint, "of") not in joined_objects(values, handle):
        raise ImpossibleValue(
            f"`{joint}` does not hold `{handle}`", action.place, "name a thing that is joined to what the joint holds"
        )
    low, high = (
        values.number(joint, end) if values.has(joint, end) else most
        for end, most in (("low", -np.inf), ("high", np.inf))
    )
    reached, turns = made.opened.get(joint, 0.0) + by, values.spec.thing(joint).model == "hinge"
    if not low - LIMIT_TOLERANCE <= reached <= high + LIMIT_TOLERANCE:
        to, stop = (
            f"{np.degrees(x):.3g} deg" if turns else f"{100 * x:.3g} cm" for x in (reached, np.clip(reached, low, high))
        )
        raise ImpossibleValue(
            f"`{joint}` would be moved to {to}, and stops at {stop}", action.place, "move it less far"
        )


def _joint_motion(made: Plan, action: Entity, joint: str, by: float) -> Callable[[float], Array]:
    """Return the motion (4, 4) of the object on a hinge or slider as a function of 0..1 of `by` (rad or m)."""
    model = made.values.spec.thing(joint).model
    if model not in ("hinge", "slider"):
        raise ImpossibleValue(
            f"`{joint}` is a {model} joint, which cannot be opened", action.place, "name a hinge or slider"
        )
    axis = np.array(made.values.vector(joint, "axis"), float)
    axis /= np.linalg.norm(axis)
    point = np.array(made.values.vector(joint, "at"), float)
    if model == "slider":
        return lambda s: translation(*(s * by * axis))
    return lambda s: rotation_about(point, axis, s * by)
