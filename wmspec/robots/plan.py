"""What arms do, planned before anything moves: the way of their joints, and what they hold when.

A plan goes by where things are at the start and by what has been done to them since; nothing is measured.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from itertools import groupby
from math import sqrt
from typing import TYPE_CHECKING

import numpy as np

from wmspec.check.ir import Thing
from wmspec.diagnostics import ImpossibleValue
from wmspec.layout import surfaces
from wmspec.robots.arm import Arm, Array, down, shift
from wmspec.robots.franka import PANDA, REST
from wmspec.robots.goods import Goods, goods
from wmspec.robots.legs import Leg, OutOfReachError, joints, stay, straight, times
from wmspec.space import Pose, turn

if TYPE_CHECKING:
    from wmspec.layout.values import Values

ARMS: dict[str, Arm] = {"panda": PANDA}
"""Model of a robot -> the arm."""

ABOVE = 0.12  # m: so high above where it takes or touches something the hand comes and goes
LEEWAY = 0.0005  # m: what the fingers leave
NARROW = 0.036  # m: how far apart the fingers are that push
BESIDE = 0.04  # m: how far from what it pushes the hand comes down
OPENS = 0.4  # s
CORNER = 0.05  # m: how far from the middle of its side each of two hands pushes that meet at a corner
SOFTLY = 0.0002  # m: from how high something is put down
END = 0.025  # m: how far from its end a long thing is taken
HINGE = ((0.0, -0.02, 0.0), (0.0, 0.02, 0.0))
FIRM = (*HINGE, (0.02, 0.0, 0.0))
"""By which points things are held, from the tool, m: two are a hinge between the pads, three hold fast."""
JERK_PEAK = 5.7735  # the greatest acceleration of a minimum-jerk way, in ways per squared time: 10 / sqrt(3)


@dataclass(frozen=True)
class Hold:
    """The `object` is held from `start` to `stop` (s) by `points` (m) of the hand's frame."""

    object: str
    start: float
    stop: float
    points: tuple[tuple[float, float, float], ...]


@dataclass(frozen=True)
class Reach:
    """The way of an arm during an action: its joints' `values` (n, k) at `times` (n,), s after the action starts."""

    robot: str
    times: tuple[float, ...]
    values: Array
    hold: Hold | None


@dataclass
class _State:
    """How an arm is while a plan is made: its joints, how wide it is open, and what it holds since which action."""

    arm: Arm
    base: Array
    q: Array
    width: float
    held: str = ""
    since: str = ""

    @property
    def tool(self) -> Array:
        """Where its tool is."""
        return self.arm.tool(self.q, self.base)


@dataclass
class _Plan:
    """A plan in the making. `choice` is which of the ways to take things is tried."""

    values: Values
    choice: int
    arms: dict[str, _State]
    things: dict[str, Goods] = field(default_factory=dict)
    reaches: dict[str, Reach] = field(default_factory=dict)

    def thing(self, action: Thing) -> Goods:
        """What an action is done to, as it is by then."""
        name = self.values.property(action.name, "object")
        if name not in self.things:
            self.things[name] = goods(self.values, name)
        return self.things[name]

    def number(self, action: Thing, name: str) -> float:
        """An argument of an action."""
        return float(self.values.property(action.name, name))


def base(values: Values, robot: str) -> Pose:
    """Where a robot stands."""
    at, yaw = values.property(robot, "at"), values.property(robot, "yaw")
    if values.has(robot, "on"):
        if len(at) == 3:
            raise ImpossibleValue(
                f"`{robot}` stands on something, so its place there is (x, y)", values.place(robot, "at")
            )
        return Pose(surfaces.top(values, values.property(robot, "on"), at).middle, turn(yaw))
    return Pose(at if len(at) == 3 else (*at, 0.0), turn(yaw))


def plan(values: Values) -> dict[str, Reach]:
    """The reaches of all arms, by the names of the actions.

    Raises WmsError with its place for what an arm cannot do.
    """
    return values.once(("", "robots"), lambda: _plan(values))


def _plan(values: Values) -> dict[str, Reach]:
    """The first plan that succeeds: a hand can take a thing in several ways."""
    problem: ImpossibleValue | None = None
    for choice in range(4):
        try:
            return _tried(values, choice)
        except _Unable as unable:
            action = unable.action
            message = f"`{action.of}` cannot {action.verb} so: {unable.reason}"
            problem = problem or ImpossibleValue(message, action.place)
    assert problem is not None
    raise problem


class _Unable(Exception):
    """One try at a plan fails at an action."""

    def __init__(self, action: Thing, reason: str) -> None:
        self.action, self.reason = action, reason


def _tried(values: Values, choice: int) -> dict[str, Reach]:
    arms = {
        t.name: _State(ARMS[t.model], matrix(base(values, t.name)), REST, ARMS[t.model].opening)
        for t in values.spec.things
        if t.kind == "robot" and t.model in ARMS
    }
    made = _Plan(values, choice, arms)
    acts = [t for t in values.spec.things if t.kind == "action" and t.of in arms and values.there(t.name)]
    acts.sort(key=lambda a: made.number(a, "start"))
    _one_at_a_time(made, acts)
    for _, together in groupby(
        acts, key=lambda a: (a.verb, made.number(a, "start"), values.property(a.name, "object"))
    ):
        every = list(together)
        thing = made.thing(every[0])
        after = _VERBS[every[0].verb](made, every, thing)
        made.things[thing.name] = after
    return made.reaches


def _one_at_a_time(made: _Plan, acts: Sequence[Thing]) -> None:
    free: dict[str, float] = {}
    for action in acts:
        start = made.number(action, "start")
        if start < free.get(action.of, 0.0) - 1e-9:
            what = f"`{action.of}` is still busy when `{action.name}` starts"
            raise ImpossibleValue(what, action.place, f"let it start at {free[action.of]:g} s or later")
        free[action.of] = start + _lasts(made, action)


def _lasts(made: _Plan, action: Thing) -> float:
    return OPENS if action.verb == "drop" else made.number(action, "duration")


# ---------------------------------------------------------------- what is done


def _pick(made: _Plan, acts: Sequence[Thing], thing: Goods) -> Goods:
    """Come from above, take it, and raise it."""
    (action,) = _alone(acts)
    height = made.number(action, "height")
    arm = made.arms[action.of]
    _free(arm, action)
    at = _taken(made, action, thing, thing.middle)
    up = shift(0.0, 0.0, height) @ at
    return _take(made, action, thing, at, straight(at, up), FIRM, height).moved((0.0, 0.0, height))


def _take(
    made: _Plan,
    action: Thing,
    thing: Goods,
    at: Array,
    rise: Callable[[float], Array],
    points: tuple[tuple[float, float, float], ...],
    height: float,
) -> Goods:
    """Come from above, take it at `at`, and go the way `rise` with it; what is too heavy slips out of the hand."""
    arm, lasts = made.arms[action.of], _lasts(made, action)
    above, opened = shift(0.0, 0.0, ABOVE) @ at, arm.arm.opening
    closed = thing.across(at) + LEEWAY
    legs = [
        Leg(0.4 * lasts, straight(arm.tool, above), opened),
        Leg(0.55 * lasts, straight(above, at), opened),
        Leg(0.65 * lasts, stay(at), closed),
        Leg(lasts, rise, closed),
    ]
    pull = JERK_PEAK * height / (0.35 * lasts) ** 2
    firm = thing.mass * (made.values.gravity + pull) <= 2 * sqrt(arm.arm.rubber * thing.friction) * arm.arm.grip
    _go(made, action, legs)
    if not firm:
        return replace(thing, slipped=True)
    start, end = made.number(action, "start") + 0.65 * lasts, float(made.values.ref("end"))
    ahead = tuple((x, y, z + arm.arm.reach) for x, y, z in points)
    hold = Hold(thing.name, start, max(end, start), ahead)
    made.reaches[action.name] = replace(made.reaches[action.name], hold=hold)
    arm.held, arm.since = thing.name, action.name
    return thing


def _lift(made: _Plan, acts: Sequence[Thing], thing: Goods) -> Goods:
    """Raise what is held; else take it at the end that is nearer, or both ends with two hands, and raise that."""
    if len(acts) == 1 and made.arms[acts[0].of].held == thing.name:
        return _raise(made, acts[0], thing)
    heights = {action.of: made.number(action, "height") for action in acts}
    sides = _sides(made, acts, thing)
    arm_length = thing.half[0] - END
    tilt = 0.0
    if len(acts) == 2:
        low, high = (heights[sides[s]] for s in (-1, 1))
        tilt = (high - low) / (2 * arm_length)
        if abs(tilt) > 0.6:
            raise _Unable(acts[0], "the two ends would be too far apart in height")
    for action in acts:
        side = next(s for s, robot in sides.items() if robot == action.of)
        yaw = _nearest(made.arms[action.of].tool, (thing.yaw,), made.choice) - thing.yaw
        way = _end_way(thing, side, arm_length, heights, sides, yaw)
        after = _take(made, action, thing, way(0.0), way, HINGE, heights[action.of])
        if after.slipped:
            return after
    return thing


def _sides(made: _Plan, acts: Sequence[Thing], thing: Goods) -> dict[int, str]:
    """Which end of a thing each arm takes: -1 is that along its -x."""
    if len(acts) > 2:
        raise ImpossibleValue("at most two arms lift one thing", acts[2].place)
    along = {a.of: float(thing.seen(made.arms[a.of].base[:3, 3])[0]) for a in acts}
    if len(along) == 1:
        return {1 if x >= 0 else -1: robot for robot, x in along.items()}
    low, high = sorted(along, key=lambda robot: along[robot])
    return {-1: low, 1: high}


def _end_way(
    thing: Goods, side: int, arm_length: float, heights: dict[str, float], sides: dict[int, str], yaw: float
) -> Callable[[float], Array]:
    """The way of a hand at an end: on the arc of the thing's own turn."""
    half, high = thing.half[0], thing.half[2]

    def together(s: float) -> tuple[float, float]:
        low, top = heights[sides[-1]] * s, heights[sides[1]] * s
        tilt = np.arcsin((top - low) / (2 * arm_length))
        return side * arm_length * float(np.cos(tilt)), high + (low + top) / 2 + side * arm_length * float(np.sin(tilt))

    def alone(s: float) -> tuple[float, float]:  # the far lower edge stays where it is
        far = half + arm_length
        angle = np.arcsin(min(1.0, s * heights[sides[side]] / far))
        x, z = far * np.cos(angle) - high * np.sin(angle), far * np.sin(angle) + high * np.cos(angle)
        return side * (float(x) - half), float(z)

    def way(s: float) -> Array:
        x, z = (together if len(sides) == 2 else alone)(s)
        place: Array = thing.frame @ shift(x, 0.0, z - high) @ down(0.0, 0.0, 0.0, yaw)
        return place

    return way


def _raise(made: _Plan, action: Thing, thing: Goods) -> Goods:
    arm, up = made.arms[action.of], (0.0, 0.0, made.number(action, "height"))
    _go(made, action, [Leg(_lasts(made, action), straight(arm.tool, shift(*up) @ arm.tool), arm.width)])
    return thing.moved(up)


def _push(made: _Plan, acts: Sequence[Thing], thing: Goods) -> Goods:
    """Touch it on the side opposite to where it is to go, and move it there; two hands move with both pushes' sum."""
    ways = {a.name: made.number(a, "distance") * heading(made.values.property(a.name, "direction")) for a in acts}
    total = np.sum(list(ways.values()), axis=0)
    for action in acts:
        arm, lasts, way = made.arms[action.of], _lasts(made, action), ways[action.name]
        _free(arm, action)
        ahead = way / np.linalg.norm(way)
        face = _nearest(arm.tool, (float(np.arctan2(ahead[1], ahead[0])),), made.choice)
        z = max(thing.middle[2], thing.top - arm.arm.palm + 0.003)
        others = (other / np.linalg.norm(other) for name, other in ways.items() if name != action.name)
        aside = sum((_beside(thing, ahead, other) for other in others), np.zeros(3))
        gap = thing.reach(ahead) + arm.arm.width / 2

        def beside(
            away: float, ahead: Array = ahead, face: float = face, z: float = z, gap: float = gap, aside: Array = aside
        ) -> Array:
            x, y = thing.middle[:2] - ahead[:2] * (gap + away) + aside[:2]
            return down(x, y, z, face)

        first, near, touch = beside(BESIDE), beside(0.001), beside(0.0)
        there = shift(*total) @ touch
        back = shift(*(-BESIDE * ahead)) @ there
        rest = _drawn_back(arm, back)
        legs = [
            Leg(0.28 * lasts, straight(arm.tool, shift(0.0, 0.0, ABOVE) @ first), NARROW),
            Leg(0.36 * lasts, straight(shift(0.0, 0.0, ABOVE) @ first, first), NARROW),
            Leg(0.41 * lasts, straight(first, near), NARROW),
            Leg(0.43 * lasts, straight(near, touch), NARROW),
            Leg(0.63 * lasts, straight(touch, there), NARROW),
            Leg(0.68 * lasts, straight(there, back), NARROW),
            Leg(0.75 * lasts, straight(back, shift(0.0, 0.0, ABOVE) @ back), NARROW),
            Leg(lasts, straight(shift(0.0, 0.0, ABOVE) @ back, rest), arm.arm.opening),
        ]
        _go(made, action, legs)
    return thing.moved(total)


def _beside(thing: Goods, ahead: Array, other: Array) -> Array:
    """How far beside the middle of its side a hand pushes, away from another one round the corner."""
    across = other - (other @ ahead) * ahead
    return across * max(0.0, min(CORNER, thing.reach(other) - NARROW / 2))


def _rotate(made: _Plan, acts: Sequence[Thing], thing: Goods) -> Goods:
    """Turn the hand, and what it holds with it, about the upright through the tool."""
    (action,) = _alone(acts)
    arm, angle = made.arms[action.of], made.number(action, "angle")
    here = arm.tool

    def way(s: float) -> Array:
        place = here.copy()
        place[:3, :3] = matrix(Pose((0.0, 0.0, 0.0), turn(s * angle)))[:3, :3] @ here[:3, :3]
        return place

    _go(made, action, [Leg(_lasts(made, action), way, arm.width)])
    return thing.turned(angle, here[:3, 3]) if arm.held == thing.name else thing


def _place(made: _Plan, acts: Sequence[Thing], thing: Goods) -> Goods:
    """Carry it above its place, put it down there, let go and draw back."""
    (action,) = _alone(acts)
    arm, lasts, values = made.arms[action.of], _lasts(made, action), made.values
    onto = values.property(action.name, "on")
    face = np.array(surfaces.top(values, onto, values.property(action.name, "at")).middle)
    if onto in made.things:
        face += made.things[onto].frame[:3, 3] - np.array(values.pose(onto).position)
    way = np.array([*face[:2], face[2] + SOFTLY]) - np.array([*thing.middle[:2], thing.middle[2] - thing.half[2]])
    here = arm.tool
    there = shift(*way) @ here
    over = shift(way[0], way[1], max(way[2] + 0.06, 0.0)) @ here
    up, rest = shift(0.0, 0.0, ABOVE) @ there, _drawn_back(arm, there)
    legs = [
        Leg(0.30 * lasts, straight(here, over), arm.width),
        Leg(0.48 * lasts, straight(over, there), arm.width),
        Leg(0.56 * lasts, stay(there), arm.arm.opening),
        Leg(0.68 * lasts, straight(there, up), arm.arm.opening),
        Leg(lasts, straight(up, rest), arm.arm.opening),
    ]
    held = arm.held == thing.name
    _let_go(made, arm, made.number(action, "start") + 0.48 * lasts)
    _go(made, action, legs)
    return thing.moved(way) if held else thing


def _drop(made: _Plan, acts: Sequence[Thing], thing: Goods) -> Goods:
    """Open the hand."""
    (action,) = _alone(acts)
    arm = made.arms[action.of]
    _let_go(made, arm, made.number(action, "start"))
    _go(made, action, [Leg(OPENS / 2, stay(arm.tool), arm.arm.opening), Leg(OPENS, stay(arm.tool), arm.arm.opening)])
    fallen = goods(made.values, thing.name).middle[2] - thing.middle[2]
    return thing.moved((0.0, 0.0, float(fallen)))


_VERBS: dict[str, Callable[[_Plan, Sequence[Thing], Goods], Goods]] = {
    "pick": _pick,
    "lift": _lift,
    "push": _push,
    "rotate": _rotate,
    "place": _place,
    "drop": _drop,
}
"""Verb -> what plans it, given the actions that do it together, and the thing; returns the thing as it is then."""


# ---------------------------------------------------------------- by which means


def _go(made: _Plan, action: Thing, legs: Sequence[Leg]) -> None:
    """Note the way of the arm, which is then where it ends."""
    arm = made.arms[action.of]
    try:
        found = joints(arm.arm, arm.base, arm.q, arm.width, legs)
    except OutOfReachError as error:
        raise _Unable(action, str(error)) from None
    made.reaches[action.name] = Reach(action.of, times(legs[-1].until), found, None)
    arm.q, arm.width = found[-1, :-2], legs[-1].width


def _taken(made: _Plan, action: Thing, thing: Goods, at: Array) -> Array:
    """Where the tool takes a thing: across one of its sides that fits between the fingers."""
    arm = made.arms[action.of].arm
    z = max(at[2], thing.top - arm.palm + 0.003)
    sides = [yaw for yaw, width in ((thing.yaw, thing.half[1]), (thing.yaw + np.pi / 2, thing.half[0]))
             if 2 * width + LEEWAY < arm.opening]  # fmt: skip
    if not sides:
        wide = 200 * min(thing.half[:2])
        raise ImpossibleValue(
            f"`{thing.name}` is {wide:.3g} cm wide, and `{action.of}` opens {100 * arm.opening:g} cm", action.place
        )
    return down(at[0], at[1], z, _nearest(made.arms[action.of].tool, sides, made.choice))


def _nearest(tool: Array, yaws: Sequence[float], choice: int) -> float:
    """The heading for a tool, of these or their opposites, that it has to turn least for; or another `choice`."""
    fore = float(np.arctan2(tool[1, 0], tool[0, 0]))
    turns = (_wrapped(yaw + flip - fore) for yaw in yaws for flip in (0.0, np.pi))
    ways = sorted(turns, key=lambda way: (round(abs(way), 6), way))
    return fore + ways[choice % len(ways)]


def _drawn_back(arm: _State, tool: Array) -> Array:
    """The place of a hand that is drawn back, turned as it is."""
    rest = tool.copy()
    rest[:3, 3] = arm.arm.tool(REST, arm.base)[:3, 3]
    return rest


def _wrapped(angle: float) -> float:
    """The angle within half a turn."""
    return float((angle + np.pi) % (2 * np.pi) - np.pi)


def _let_go(made: _Plan, arm: _State, moment: float) -> None:
    """Let go at `moment` (s) of what an arm holds."""
    reach = made.reaches.get(arm.since)
    if reach and reach.hold:
        made.reaches[arm.since] = replace(reach, hold=replace(reach.hold, stop=moment))
    arm.held = arm.since = ""


def _alone(acts: Sequence[Thing]) -> Sequence[Thing]:
    if len(acts) > 1:
        raise ImpossibleValue(
            f"two arms cannot {acts[1].verb} one thing together", acts[1].place, "let them push or lift it"
        )
    return acts


def _free(arm: _State, action: Thing) -> None:
    if arm.held:
        raise ImpossibleValue(
            f"`{action.of}` holds `{arm.held}`, so it cannot {action.verb}",
            action.place,
            "let it `place` or `drop` that first",
        )


def heading(direction: str | float) -> Array:
    """The unit vector (3,) of a direction word or an angle."""
    from wmspec.layout.motion import angle

    found = angle(direction)
    return np.array([np.cos(found), np.sin(found), 0.0])


def matrix(pose: Pose) -> Array:
    """A pose as a matrix (4, 4)."""
    found = np.eye(4)
    found[:3, 3] = pose.position
    for i, axis in enumerate(((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))):
        found[:3, i] = np.array(pose.apply(axis)) - found[:3, 3]
    return found
