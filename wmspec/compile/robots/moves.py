"""What arms do to where things are: `push`, `carry`, `rotate`, `tilt`, and `open` and `close` what joints hold."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from wmspec.compile.layout.motion import angle as heading
from wmspec.compile.robots.arm import Array, down, shift
from wmspec.compile.robots.grasps import FIRM, LEEWAY, PALM, sides_of, taken
from wmspec.compile.robots.legs import Leg, smooth, spun, stay, straight
from wmspec.compile.robots.manipuland import Goods, together
from wmspec.compile.robots.planning import ABOVE, OPENS, PUSHES, Plan, Unable, only
from wmspec.core.diagnostics import ImpossibleValue
from wmspec.lang.check.ir.ir import Thing

NARROW = 0.036  # m: how far apart the fingers are that push
SLIM = 0.046  # m: what is less wide is pushed by fingers that are closed
BESIDE = 0.04  # m: how far from what it pushes the hand comes down
CORNER = 0.05  # m: how far from the middle of its side each of two hands pushes that meet at a corner
TIP = 0.035  # m: how far from its end a thing is pushed that is turned
NEAR = 1e-6  # rad or m: so far beyond its limit a joint is at it
UP = np.array([0.0, 0.0, 1.0])


def push(made: Plan, acts: Sequence[Thing], thing: Goods) -> Goods:
    """Touch it on the side opposite to where it is to go, and move it there.

    Two hands that push one way, or against each other, each push their end of it so far; two that push across each
    other move it by the sum.
    """
    ways = {a.name: made.number(a, "distance") * level(made.values.direction(a.name)) for a in acts}
    asides = {a.name: np.zeros(3) for a in acts}
    total, turned = np.sum(list(ways.values()), axis=0), 0.0
    if len(acts) == 2:
        first, second = (way / np.linalg.norm(way) for way in ways.values())
        if abs(first @ second) > 0.99:
            asides, total, turned = _by_the_ends(made, acts, thing, ways)
        else:
            asides = dict(zip(ways, (_beside(thing, first, second), _beside(thing, second, first)), strict=True))
    rigid = shift(*total) @ around(thing.middle, UP, turned)
    for action in acts:
        _pushed(made, action, thing, ways[action.name], asides[action.name], _turning(thing, total, turned))
    return thing.put(rigid)


def carry(made: Plan, acts: Sequence[Thing], thing: Goods) -> Goods:
    """Move the hand level, and what it holds with it."""
    action = only(acts)
    made.wields(action)
    arm = made.arms[action.of]
    way = made.number(action, "distance") * level(made.values.direction(action.name))
    made.go(action, [Leg(made.lasts(action), straight(arm.tool, shift(*way) @ arm.tool), arm.width)])
    return thing.moved(way) if arm.held == thing.name else thing


def rotate(made: Plan, acts: Sequence[Thing], thing: Goods) -> Goods:
    """Turn the hand, and what it holds with it, about the upright through the tool."""
    return _turn_hand(made, only(acts), thing, UP)


def tilt(made: Plan, acts: Sequence[Thing], thing: Goods) -> Goods:
    """Tip the hand over, and what it holds with it, as one pours."""
    action = only(acts)
    return _turn_hand(made, action, thing, np.cross(UP, level(made.values.direction(action.name))))


def open_(made: Plan, acts: Sequence[Thing], thing: Goods) -> Goods:
    """Take a handle, move it as its joint lets it, let go and draw back."""
    return _along_joint(made, only(acts), thing, 1.0)


def close(made: Plan, acts: Sequence[Thing], thing: Goods) -> Goods:
    """The same, the other way."""
    return _along_joint(made, only(acts), thing, -1.0)


# ---------------------------------------------------------------- by which means


def level(direction: Any) -> Array:
    """The unit vector (3,) of a direction word or an angle."""
    angle = heading(direction)
    return np.array([np.cos(angle), np.sin(angle), 0.0])


def around(point: Array, axis: Array, angle: float) -> Array:
    """A turn (4, 4) about an axis through a point."""
    turn = np.eye(4)
    turn[:3, :3] = spun(angle * axis)
    return np.asarray(shift(*point) @ turn @ shift(*(-point)))


def _pushed(made: Plan, action: Thing, thing: Goods, way: Array, aside: Array, move: Callable[[float], Array]) -> None:
    """One hand that pushes: it comes down beside the thing, goes with it as it moves, and draws back."""
    arm, lasts = made.arms[action.of], made.lasts(action)
    made.free(action)
    ahead = way / np.linalg.norm(way)
    face = made.nearest(action.of, (float(np.arctan2(ahead[1], ahead[0])),))
    z = max(thing.middle[2], thing.top - arm.arm.palm + PALM)
    gap = thing.reach(ahead) + arm.arm.width / 2
    apart = NARROW if 2 * thing.reach(np.cross(UP, ahead)) > SLIM else 0.0

    def beside(away: float) -> Array:
        x, y = thing.middle[:2] - ahead[:2] * (gap + away) + aside[:2]
        return down(x, y, z, face)

    first, near, touch = beside(BESIDE), beside(0.001), beside(0.0)
    there = move(1.0) @ touch
    back = shift(*(-BESIDE * (move(1.0)[:3, :3] @ ahead))) @ there
    above = shift(0.0, 0.0, ABOVE)
    legs = [
        Leg(0.28 * lasts, straight(arm.tool, above @ first), apart),
        Leg(0.36 * lasts, straight(above @ first, first), apart),
        Leg(0.41 * lasts, straight(first, near), apart),
        Leg(PUSHES[0] * lasts, straight(near, touch), apart),
        Leg(PUSHES[1] * lasts, lambda s: np.asarray(move(s) @ touch), apart),
        Leg(0.65 * lasts, stay(there), apart),  # or the spline would swing .1 mm beyond it
        Leg(0.695 * lasts, straight(there, back), apart),
        Leg(0.762 * lasts, straight(back, above @ back), apart),
        Leg(lasts, straight(above @ back, arm.drawn_back(back)), arm.arm.opening),
    ]
    made.go(action, legs)


def _turning(thing: Goods, total: Array, angle: float) -> Callable[[float], Array]:
    """How a thing that is pushed moves (4, 4), for 0..1 of its way."""
    return lambda s: np.asarray(shift(*(s * total)) @ around(thing.middle, UP, s * angle))


def _by_the_ends(
    made: Plan, acts: Sequence[Thing], thing: Goods, ways: dict[str, Array]
) -> tuple[dict[str, Array], Array, float]:
    """Where on its side each hand pushes, how far the thing goes then, and by which angle (rad) it turns."""
    sides, along = sides_of(made, acts, thing), thing.frame[:3, 0]
    across = np.cross(UP, along)
    arm = thing.half[0] - TIP
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


def _beside(thing: Goods, ahead: Array, other: Array) -> Array:
    """How far beside the middle of its side a hand pushes, away from another one round the corner."""
    across = other - (other @ ahead) * ahead
    return np.asarray(across * max(0.0, min(CORNER, thing.reach(other) - NARROW / 2)))


def _turn_hand(made: Plan, action: Thing, thing: Goods, axis: Array) -> Goods:
    """Turn the hand about an axis through the tool, and what it holds with it."""
    arm, angle = made.arms[action.of], made.number(action, "angle")
    here = arm.tool
    point = here[:3, 3]
    way = lambda s: np.asarray(around(point, axis, s * angle) @ here)  # noqa: E731
    made.wields(action)
    try:
        made.go(action, [Leg(made.lasts(action), way, arm.width)])
    except Unable as unable:
        if unable.after is None:
            raise
        turned = abs(np.degrees(angle)) * smooth(unable.after / made.lasts(action))
        reason = f"its joints stop after some {turned:.0f} of {abs(np.degrees(angle)):.0f} deg"
        raise Unable(action, reason, f"{action.verb} it less far, or the other way", unable.after) from None
    return thing.put(around(point, axis, angle)) if arm.held == thing.name else thing


def _along_joint(made: Plan, action: Thing, handle: Goods, sign: float) -> Goods:
    """Take a handle and move it by so much along the way that its joint leaves it; let go, and draw back."""
    arm, lasts, joint = made.arms[action.of], made.lasts(action), made.values.reference(action.name, "joint")
    made.free(action)
    by = sign * made.number(action, "far")
    _lets(made, action, handle.name, joint, by)
    at, move = taken(made, action, handle), _joint_way(made, action, joint, by)
    above, opened, closed = shift(0.0, 0.0, ABOVE), arm.arm.opening, handle.across(at) + LEEWAY
    there = move(1.0) @ at
    legs = [
        Leg(0.24 * lasts, straight(arm.tool, above @ at), opened),
        Leg(0.32 * lasts, straight(above @ at, at), opened),
        Leg(OPENS[0] * lasts, stay(at), closed),
        Leg(OPENS[1] * lasts, lambda s: np.asarray(move(s) @ at), closed),
        Leg(0.70 * lasts, stay(there), opened),
        Leg(0.77 * lasts, straight(there, above @ there), opened),
        Leg(lasts, straight(above @ there, arm.drawn_back(there)), opened),
    ]
    made.go(action, legs)
    start = made.number(action, "start")
    made.hold(action, handle.name, start + OPENS[0] * lasts, FIRM)
    made.let_go(action, start + OPENS[1] * lasts)
    made.opened[joint] = made.opened.get(joint, 0.0) + by
    return handle.put(move(1.0))


def _lets(made: Plan, action: Thing, handle: str, joint: str, by: float) -> None:
    """Complain unless a joint holds the handle, or what that is joined to, and lets it be moved so far (rad or m)."""
    values = made.values
    if values.reference(joint, "of") not in together(values, handle):
        raise ImpossibleValue(
            f"`{joint}` does not hold `{handle}`", action.place, "name a thing that is joined to what the joint holds"
        )
    low, high = (
        values.number(joint, end) if values.has(joint, end) else most
        for end, most in (("low", -np.inf), ("high", np.inf))
    )
    reached, turns = made.opened.get(joint, 0.0) + by, values.spec.thing(joint).model == "hinge"
    if not low - NEAR <= reached <= high + NEAR:
        to, stop = (
            f"{np.degrees(x):.3g} deg" if turns else f"{100 * x:.3g} cm" for x in (reached, np.clip(reached, low, high))
        )
        raise ImpossibleValue(
            f"`{joint}` would be moved to {to}, and stops at {stop}", action.place, "move it less far"
        )


def _joint_way(made: Plan, action: Thing, joint: str, by: float) -> Callable[[float], Array]:
    """How what a hinge or slider holds moves (4, 4), for 0..1 of `by` (rad or m)."""
    model = made.values.spec.thing(joint).model
    if model not in ("hinge", "slider"):
        raise ImpossibleValue(
            f"`{joint}` is a {model} joint, which nobody opens", action.place, "name a hinge or slider"
        )
    axis = np.array(made.values.vector(joint, "axis"), float)
    axis /= np.linalg.norm(axis)
    point = np.array(made.values.vector(joint, "at"), float)
    if model == "slider":
        return lambda s: shift(*(s * by * axis))
    return lambda s: around(point, axis, s * by)
