"""Planners of grasping actions: `pick`, `grasp`, `lift`, `place`, `drop`."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from math import sqrt

import numpy as np

from wmspec.compile.layout import surfaces
from wmspec.compile.robots.arm import Array, downward_pose, translation
from wmspec.compile.robots.manipuland import Manipuland, joined_objects, manipuland_of
from wmspec.compile.robots.planning import APPROACH_HEIGHT, Plan, PlanningError, require_single
from wmspec.compile.robots.schedule import HAND_OPENING_TIME
from wmspec.compile.robots.tool_path import ToolSegment, stay, straight
from wmspec.core.diagnostics import ImpossibleValue
from wmspec.lang.check.ir.ir import Entity

FINGER_CLEARANCE = 0.0005  # m: between finger and object before the grasp
RELEASE_HEIGHT = 0.0002  # m: height from which an object is released
END_DISTANCE = 0.025  # m: distance of a grasp from the end of a long object
PALM_CLEARANCE = 0.003  # m: between the palm and the grasped object
SUPPORT_CLEARANCE = 0.001  # m: between the fingertips and the object's support
HINGE_POINTS = ((0.0, -0.02, 0.0), (0.0, 0.02, 0.0))
FIRM_POINTS = (*HINGE_POINTS, (0.02, 0.0, 0.0))
"""Holding points relative to the tool, m: two form a hinge between the pads, three hold rigidly."""
JERK_PEAK = 5.7735  # peak acceleration of a minimum-jerk motion, in lengths per squared duration: 10 / sqrt(3)
CLOSED_SHARE = 0.65  # share of a grasping action after which the hand is closed


def pick(made: Plan, acts: Sequence[Entity], thing: Manipuland) -> Manipuland:
    """Plan an approach from above, a grasp and a lift."""
    action, height = require_single(acts), made.number(acts[0], "height")
    made.free(action)
    at = grasp_pose(made, action, thing)
    up = translation(0.0, 0.0, height) @ at
    firm = can_carry(made, action, thing.mass, thing.friction, height)
    return take(made, action, thing, at, straight(at, up), FIRM_POINTS, firm).moved((0.0, 0.0, height))


def grasp(made: Plan, acts: Sequence[Entity], thing: Manipuland) -> Manipuland:
    """Plan an approach from above and a grasp, of a resting object or one in another hand."""
    action = require_single(acts)
    made.free(action)
    at = grasp_pose(made, action, thing)
    return take(
        made, action, thing, at, stay(at), FIRM_POINTS, can_carry(made, action, thing.mass, thing.friction, 0.0)
    )


def lift(made: Plan, acts: Sequence[Entity], thing: Manipuland) -> Manipuland:
    """Plan to raise a held object; else grasp it at the nearer end, or at both ends with two hands, and raise it."""
    if len(acts) == 1 and made.arms[acts[0].of].held == thing.name:
        return _raise(made, acts[0], thing)
    sides, lengths, hands, heights = end_actions(made, acts, thing), {}, {}, {}
    for side, action in sides.items():
        made.free(action)
        grasp_pose(made, action, thing)
        x, y = made.values.pair(action.name, "at")
        lengths[side] = thing.half[0] - END_DISTANCE + side * x
        turned = made.nearest(action.of, (thing.yaw,)) - thing.yaw
        hands[side] = translation(0.0, y, 0.0) @ downward_pose(0.0, 0.0, 0.0, turned)
        height = made.number(action, "height")
        if thing.has((thing.frame @ translation(side * lengths[side], y, 0.0))[:3, 3]) and can_carry(
            made, action, 0.5 * thing.mass, thing.friction, height
        ):
            heights[side] = height
    if len(heights) == 2 and abs(heights[1] - heights[-1]) > 0.6 * sum(lengths.values()):
        raise PlanningError(acts[0], "the two ends would be too far apart in height", "let their heights differ less")
    for side, action in sides.items():
        start = thing.frame @ translation(side * lengths[side], 0.0, 0.0) @ hands[side]
        way = straight(start, translation(0.0, 0.0, made.number(action, "height")) @ start)
        if side in heights:
            way = _end_path(thing, side, lengths, heights, hands[side])
        take(made, action, thing, start, way, HINGE_POINTS, side in heights)
    return thing


def place(made: Plan, acts: Sequence[Entity], thing: Manipuland) -> Manipuland:
    """Plan to carry an object above its place, put it down, release it and retract."""
    action = require_single(acts)
    arm, lasts, values = made.arms[action.of], made.duration(action), made.values
    onto = values.reference(action.name, "on")
    if onto in joined_objects(values, thing.name):
        raise ImpossibleValue(f"`{thing.name}` cannot be put on itself", action.place, "name what it is to stand on")
    made.require_held(action)
    face = np.array(surfaces.top_point(values, onto, values.pair(action.name, "at")).middle)
    face = (made.motion(onto) @ [*face, 1.0])[:3]
    way = np.array([*face[:2], face[2] + RELEASE_HEIGHT]) - np.array(
        [*thing.middle[:2], thing.middle[2] - thing.half[2]]
    )
    here = arm.tool
    there = translation(*way) @ here
    over = translation(way[0], way[1], max(way[2] + 0.06, 0.0)) @ here
    up, rest = translation(0.0, 0.0, APPROACH_HEIGHT) @ there, arm.retracted(there)
    legs = [
        ToolSegment(0.30 * lasts, straight(here, over), arm.width),
        ToolSegment(0.48 * lasts, straight(over, there), arm.width),
        ToolSegment(0.56 * lasts, stay(there), arm.arm.opening),
        ToolSegment(0.68 * lasts, straight(there, up), arm.arm.opening),
        ToolSegment(lasts, straight(up, rest), arm.arm.opening),
    ]
    held = arm.held == thing.name
    made.release(action, made.number(action, "start") + 0.48 * lasts)
    made.go(action, legs)
    return thing.moved(way) if held else thing


def drop(made: Plan, acts: Sequence[Entity], thing: Manipuland) -> Manipuland:
    """Plan to open the hand; an object that no other hand holds falls to where it was grasped."""
    action = require_single(acts)
    arm = made.arms[action.of]
    made.require_held(action)
    held = arm.held == thing.name
    made.release(action, made.number(action, "start"))
    made.go(action, [ToolSegment(part * HAND_OPENING_TIME, stay(arm.tool), arm.arm.opening) for part in (0.5, 1.0)])
    if not held or any(other.held == thing.name for other in made.arms.values()):
        return thing
    return thing.moved((0.0, 0.0, float(manipuland_of(made.values, thing.name).middle[2] - thing.middle[2])))


# ---------------------------------------------------------------- steps


def take(
    made: Plan,
    action: Entity,
    thing: Manipuland,
    at: Array,
    rise: Callable[[float], Array],
    points: tuple[tuple[float, float, float], ...],
    firm: bool,
) -> Manipuland:
    """Plan an approach from above, a grasp at `at`, and the motion `rise` with the object.

    Without `firm` the object slips out of the hand, and a hand beside it closes on nothing: the object then stays. Both
    fingers close symmetrically, so an off-centre object is moved to the middle.
    """
    arm, lasts = made.arms[action.of], made.duration(action)
    above, opened, hits = translation(0.0, 0.0, APPROACH_HEIGHT) @ at, arm.arm.opening, thing.has(at[:3, 3])
    closed = thing.across(at) + FINGER_CLEARANCE if hits else 0.0
    legs = [
        ToolSegment(0.4 * lasts, straight(arm.tool, above), opened),
        ToolSegment(0.55 * lasts, straight(above, at), opened),
        ToolSegment(CLOSED_SHARE * lasts, stay(at), closed),
        ToolSegment(lasts, rise, closed),
    ]
    made.go(action, legs)
    arm.intended = thing.name
    if hits and firm:
        made.hold(action, thing.name, made.number(action, "start") + CLOSED_SHARE * lasts, points)
    if not hits:
        return replace(thing, slipped=True)
    between = at[:3, 1] * float(at[:3, 1] @ (at[:3, 3] - thing.middle))
    return replace(thing.moved(between), slipped=not firm)


def can_carry(made: Plan, action: Entity, mass: float, friction: float, height: float) -> bool:
    """Whether friction in the hand holds a mass (kg) that is raised by a height (m); otherwise it slips."""
    arm = made.arms[action.of].arm
    pull = JERK_PEAK * height / ((1 - CLOSED_SHARE) * made.duration(action)) ** 2
    return mass * (made.values.gravity + pull) <= 2 * sqrt(arm.rubber * friction) * arm.grip


def grasp_pose(made: Plan, action: Entity, thing: Manipuland) -> Array:
    """Return the tool pose that grasps an object across a side that fits between the fingers."""
    arm = made.arms[action.of].arm
    x, y = made.values.pair(action.name, "at")
    spot = (thing.frame @ translation(x, y, 0.0))[:3, 3]
    sides = [
        yaw
        for yaw, width in ((thing.yaw, thing.half[1]), (thing.yaw + np.pi / 2, thing.half[0]))
        if 2 * width + FINGER_CLEARANCE < arm.opening
    ]
    if not sides:
        wide = 200 * min(thing.half[:2])
        raise ImpossibleValue(
            f"`{thing.name}` is {wide:.3g} cm wide, and `{action.of}` takes what is less than {100 * arm.opening:g} cm",
            action.place,
            "make it narrower, or take a handle: an object of its own that a joint holds to it",
        )
    ends = float(arm.finger + arm.tip[1, 2] - arm.reach)
    low = max(thing.top - arm.palm + PALM_CLEARANCE, thing.middle[2] - thing.half[2] + ends + SUPPORT_CLEARANCE)
    return downward_pose(spot[0], spot[1], max(spot[2], low), made.nearest(action.of, sides))


def end_actions(made: Plan, acts: Sequence[Entity], thing: Manipuland) -> dict[int, Entity]:
    """Return the action at each end of an object; key -1 is the end along its -x."""
    if len(acts) > 2:
        raise ImpossibleValue(f"at most two arms {acts[2].verb} one thing", acts[2].place)
    along = {a.name: float(thing.to_local(made.arms[a.of].base[:3, 3])[0]) for a in acts}
    if len(acts) == 1:
        return {1 if along[acts[0].name] >= 0 else -1: acts[0]}
    low, high = sorted(acts, key=lambda action: along[action.name])
    return {-1: low, 1: high}


def _end_path(
    thing: Manipuland, side: int, lengths: dict[int, float], heights: dict[int, float], hand: Array
) -> Callable[[float], Array]:
    """Return the path of a hand at an end of an object, on the arc of the object's rotation."""
    half, high, length = thing.half[0], thing.half[2], lengths[side]

    def joined_objects(s: float) -> tuple[float, float]:
        low, top = heights[-1] * s, heights[1] * s
        tilt = float(np.arcsin((top - low) / (lengths[-1] + lengths[1])))
        return side * length * np.cos(tilt), high + low + (lengths[-1] + side * length) * np.sin(tilt)

    def alone(s: float) -> tuple[float, float]:  # the object tips about its far lower edge
        far = half + length
        angle = float(np.arcsin(min(1.0, s * heights[side] / far)))
        x, z = far * np.cos(angle) - high * np.sin(angle), far * np.sin(angle) + high * np.cos(angle)
        return side * (x - half), z

    def way(s: float) -> Array:
        x, z = (joined_objects if len(heights) == 2 else alone)(s)
        return np.asarray(thing.frame @ translation(x, 0.0, z - high) @ hand)

    return way


def _raise(made: Plan, action: Entity, thing: Manipuland) -> Manipuland:
    made.require_held(action)
    arm, up = made.arms[action.of], (0.0, 0.0, made.number(action, "height"))
    made.go(action, [ToolSegment(made.duration(action), straight(arm.tool, translation(*up) @ arm.tool), arm.width)])
    return thing.moved(up)
