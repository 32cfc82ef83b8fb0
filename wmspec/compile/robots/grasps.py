"""What hands do that take, put down and let go: `pick`, `grasp`, `lift`, `place`, `drop`."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from math import sqrt

import numpy as np

from wmspec.compile.layout import surfaces
from wmspec.compile.robots.arm import Array, down, shift
from wmspec.compile.robots.legs import Leg, stay, straight
from wmspec.compile.robots.manipuland import Goods, goods, together
from wmspec.compile.robots.planning import ABOVE, Plan, Unable, only
from wmspec.compile.robots.schedule import OPENS
from wmspec.core.diagnostics import ImpossibleValue
from wmspec.lang.check.ir.ir import Thing

LEEWAY = 0.0005  # m: what the fingers leave
SOFTLY = 0.0002  # m: from how high something is put down
END = 0.025  # m: how far from its end a long thing is taken
PALM = 0.003  # m: how far the palm stays above what the fingers take
TOUCH = 0.001  # m: how far their ends stay above what it stands on
HINGE = ((0.0, -0.02, 0.0), (0.0, 0.02, 0.0))
FIRM = (*HINGE, (0.02, 0.0, 0.0))
"""By which points things are held, from the tool, m: two are a hinge between the pads, three hold fast."""
JERK_PEAK = 5.7735  # the greatest acceleration of a minimum-jerk way, in ways per squared time: 10 / sqrt(3)
CLOSED = 0.65  # of the time of what takes something, the hand is closed


def pick(made: Plan, acts: Sequence[Thing], thing: Goods) -> Goods:
    """Come from above, take it, and raise it."""
    action, height = only(acts), made.number(acts[0], "height")
    made.free(action)
    at = taken(made, action, thing)
    up = shift(0.0, 0.0, height) @ at
    firm = carries(made, action, thing.mass, thing.friction, height)
    return take(made, action, thing, at, straight(at, up), FIRM, firm).moved((0.0, 0.0, height))


def grasp(made: Plan, acts: Sequence[Thing], thing: Goods) -> Goods:
    """Come from above and take it, where it is: on something, or in another hand."""
    action = only(acts)
    made.free(action)
    at = taken(made, action, thing)
    return take(made, action, thing, at, stay(at), FIRM, carries(made, action, thing.mass, thing.friction, 0.0))


def lift(made: Plan, acts: Sequence[Thing], thing: Goods) -> Goods:
    """Raise what is held; else take it at the end that is nearer, or both ends with two hands, and raise that."""
    if len(acts) == 1 and made.arms[acts[0].of].held == thing.name:
        return _raise(made, acts[0], thing)
    sides, lengths, hands, heights = sides_of(made, acts, thing), {}, {}, {}
    for side, action in sides.items():
        made.free(action)
        taken(made, action, thing)
        x, y = made.values.pair(action.name, "at")
        lengths[side] = thing.half[0] - END + side * x
        turned = made.nearest(action.of, (thing.yaw,)) - thing.yaw
        hands[side] = shift(0.0, y, 0.0) @ down(0.0, 0.0, 0.0, turned)
        height = made.number(action, "height")
        if thing.has((thing.frame @ shift(side * lengths[side], y, 0.0))[:3, 3]) and carries(
            made, action, 0.5 * thing.mass, thing.friction, height
        ):
            heights[side] = height
    if len(heights) == 2 and abs(heights[1] - heights[-1]) > 0.6 * sum(lengths.values()):
        raise Unable(acts[0], "the two ends would be too far apart in height", "let their heights differ less")
    for side, action in sides.items():
        start = thing.frame @ shift(side * lengths[side], 0.0, 0.0) @ hands[side]
        way = straight(start, shift(0.0, 0.0, made.number(action, "height")) @ start)
        if side in heights:
            way = _end_way(thing, side, lengths, heights, hands[side])
        take(made, action, thing, start, way, HINGE, side in heights)
    return thing


def place(made: Plan, acts: Sequence[Thing], thing: Goods) -> Goods:
    """Carry it above its place, put it down there, let go and draw back."""
    action = only(acts)
    arm, lasts, values = made.arms[action.of], made.lasts(action), made.values
    onto = values.reference(action.name, "on")
    if onto in together(values, thing.name):
        raise ImpossibleValue(f"`{thing.name}` cannot be put on itself", action.place, "name what it is to stand on")
    made.wields(action)
    face = np.array(surfaces.top(values, onto, values.pair(action.name, "at")).middle)
    face = (made.motion(onto) @ [*face, 1.0])[:3]
    way = np.array([*face[:2], face[2] + SOFTLY]) - np.array([*thing.middle[:2], thing.middle[2] - thing.half[2]])
    here = arm.tool
    there = shift(*way) @ here
    over = shift(way[0], way[1], max(way[2] + 0.06, 0.0)) @ here
    up, rest = shift(0.0, 0.0, ABOVE) @ there, arm.drawn_back(there)
    legs = [
        Leg(0.30 * lasts, straight(here, over), arm.width),
        Leg(0.48 * lasts, straight(over, there), arm.width),
        Leg(0.56 * lasts, stay(there), arm.arm.opening),
        Leg(0.68 * lasts, straight(there, up), arm.arm.opening),
        Leg(lasts, straight(up, rest), arm.arm.opening),
    ]
    held = arm.held == thing.name
    made.let_go(action, made.number(action, "start") + 0.48 * lasts)
    made.go(action, legs)
    return thing.moved(way) if held else thing


def drop(made: Plan, acts: Sequence[Thing], thing: Goods) -> Goods:
    """Open the hand; what no other hand holds falls to where it was taken from."""
    action = only(acts)
    arm = made.arms[action.of]
    made.wields(action)
    held = arm.held == thing.name
    made.let_go(action, made.number(action, "start"))
    made.go(action, [Leg(part * OPENS, stay(arm.tool), arm.arm.opening) for part in (0.5, 1.0)])
    if not held or any(other.held == thing.name for other in made.arms.values()):
        return thing
    return thing.moved((0.0, 0.0, float(goods(made.values, thing.name).middle[2] - thing.middle[2])))


# ---------------------------------------------------------------- by which means


def take(
    made: Plan,
    action: Thing,
    thing: Goods,
    at: Array,
    rise: Callable[[float], Array],
    points: tuple[tuple[float, float, float], ...],
    firm: bool,
) -> Goods:
    """Come from above, take it at `at`, and go the way `rise` with it.

    What is not held `firm` slips out of the hand, and a hand beside it closes on nothing: then it stays where it is.
    The fingers close alike: what is not in the middle between them is moved there.
    """
    arm, lasts = made.arms[action.of], made.lasts(action)
    above, opened, hits = shift(0.0, 0.0, ABOVE) @ at, arm.arm.opening, thing.has(at[:3, 3])
    closed = thing.across(at) + LEEWAY if hits else 0.0
    legs = [
        Leg(0.4 * lasts, straight(arm.tool, above), opened),
        Leg(0.55 * lasts, straight(above, at), opened),
        Leg(CLOSED * lasts, stay(at), closed),
        Leg(lasts, rise, closed),
    ]
    made.go(action, legs)
    arm.wanted = thing.name
    if hits and firm:
        made.hold(action, thing.name, made.number(action, "start") + CLOSED * lasts, points)
    if not hits:
        return replace(thing, slipped=True)
    between = at[:3, 1] * float(at[:3, 1] @ (at[:3, 3] - thing.middle))
    return replace(thing.moved(between), slipped=not firm)


def carries(made: Plan, action: Thing, mass: float, friction: float, height: float) -> bool:
    """Whether friction in the hand carries a mass (kg) that is raised by a height (m): if not, it slips."""
    arm = made.arms[action.of].arm
    pull = JERK_PEAK * height / ((1 - CLOSED) * made.lasts(action)) ** 2
    return mass * (made.values.gravity + pull) <= 2 * sqrt(arm.rubber * friction) * arm.grip


def taken(made: Plan, action: Thing, thing: Goods) -> Array:
    """Where the tool takes a thing: across one of its sides that fits between the fingers."""
    arm = made.arms[action.of].arm
    x, y = made.values.pair(action.name, "at")
    spot = (thing.frame @ shift(x, y, 0.0))[:3, 3]
    sides = [
        yaw
        for yaw, width in ((thing.yaw, thing.half[1]), (thing.yaw + np.pi / 2, thing.half[0]))
        if 2 * width + LEEWAY < arm.opening
    ]
    if not sides:
        wide = 200 * min(thing.half[:2])
        raise ImpossibleValue(
            f"`{thing.name}` is {wide:.3g} cm wide, and `{action.of}` takes what is less than {100 * arm.opening:g} cm",
            action.place,
            "make it narrower, or take a handle: an object of its own that a joint holds to it",
        )
    ends = float(arm.finger + arm.tip[1, 2] - arm.reach)
    low = max(thing.top - arm.palm + PALM, thing.middle[2] - thing.half[2] + ends + TOUCH)
    return down(spot[0], spot[1], max(spot[2], low), made.nearest(action.of, sides))


def sides_of(made: Plan, acts: Sequence[Thing], thing: Goods) -> dict[int, Thing]:
    """Which arm's action is at which end of a thing: -1 is that along its -x."""
    if len(acts) > 2:
        raise ImpossibleValue(f"at most two arms {acts[2].verb} one thing", acts[2].place)
    along = {a.name: float(thing.seen(made.arms[a.of].base[:3, 3])[0]) for a in acts}
    if len(acts) == 1:
        return {1 if along[acts[0].name] >= 0 else -1: acts[0]}
    low, high = sorted(acts, key=lambda action: along[action.name])
    return {-1: low, 1: high}


def _end_way(
    thing: Goods, side: int, lengths: dict[int, float], heights: dict[int, float], hand: Array
) -> Callable[[float], Array]:
    """The way of a hand at an end, so far (m) from the middle: on the arc of the thing's own turn."""
    half, high, length = thing.half[0], thing.half[2], lengths[side]

    def together(s: float) -> tuple[float, float]:
        low, top = heights[-1] * s, heights[1] * s
        tilt = float(np.arcsin((top - low) / (lengths[-1] + lengths[1])))
        return side * length * np.cos(tilt), high + low + (lengths[-1] + side * length) * np.sin(tilt)

    def alone(s: float) -> tuple[float, float]:  # the far lower edge stays where it is
        far = half + length
        angle = float(np.arcsin(min(1.0, s * heights[side] / far)))
        x, z = far * np.cos(angle) - high * np.sin(angle), far * np.sin(angle) + high * np.cos(angle)
        return side * (x - half), z

    def way(s: float) -> Array:
        x, z = (together if len(heights) == 2 else alone)(s)
        return np.asarray(thing.frame @ shift(x, 0.0, z - high) @ hand)

    return way


def _raise(made: Plan, action: Thing, thing: Goods) -> Goods:
    made.wields(action)
    arm, up = made.arms[action.of], (0.0, 0.0, made.number(action, "height"))
    made.go(action, [Leg(made.lasts(action), straight(arm.tool, shift(*up) @ arm.tool), arm.width)])
    return thing.moved(up)
