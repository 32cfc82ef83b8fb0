"""What cars and walkers do, planned before anything moves: where they are, and how they are turned, at each time.

A plan goes by where things are at the start, whatever may happen to them.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import pairwise
from typing import TYPE_CHECKING

from wmspec.compile.robots.base_pose import base
from wmspec.compile.robots.obstacles import Outline, around, hull, obstacles
from wmspec.compile.robots.roads import LONG, WIDE, OffRoadError, Traffic, road
from wmspec.compile.robots.schedule import in_turn, lasts
from wmspec.compile.robots.wayfinding import legs_to
from wmspec.compile.robots.ways import Leg, Spot, Straight, along, gone
from wmspec.core.diagnostics import ImpossibleValue
from wmspec.core.space import Pose, Quaternion, Vector, add, rotate, turn
from wmspec.lang.check.ir.ir import Thing

if TYPE_CHECKING:
    from wmspec.compile.layout.values import Values

RATE = 30  # Hz: so many places of a way are written
DIGITS = 9  # what is rounded so is the same on every processor
NECK = 1.2  # m: so high above the ground a walker's head nods
GIRTH = 0.25  # m: a walker is a disc of this radius
CLEAR = 0.02  # m: it stops so far before what it would touch
SIDLES = 0.005  # m: so far it goes at a time where it nearly touches something beside it
WALKERS = (0.1, 1.7)  # m above the ground: what reaches between these stops a walker
BUMPERS = (0.2, 1.5)  # m above the ground: the same of a car
LOOKS = 0.2  # m: so often along its way a car is held against what stands there
FASTEST = {"car": 50.0, "walker": 8.0}  # m/s: a car on a motorway, a sprinter
SPINS = 4 * math.pi  # rad/s: nobody turns about faster


@dataclass(frozen=True)
class Travel:
    """Where a robot is during an action: `points` (m) and `turns` at `times` (s after it starts)."""

    times: tuple[float, ...]
    points: tuple[Vector, ...]
    turns: tuple[Quaternion, ...]


@dataclass(frozen=True)
class _Stretch:
    """What one action comes to: `at` says the place and the pitch (rad) after so much of its `length` (m or rad).

    One that `flows` goes on into the next one without a halt.
    """

    action: Thing
    start: float
    lasts: float
    length: float
    at: Callable[[float], tuple[Spot, float]]
    flows: bool = False

    @property
    def pace(self) -> float:
        """Its mean speed."""
        return self.length / self.lasts


def travels(values: Values) -> dict[str, Travel]:
    """What all cars and walkers do, by the names of the actions.

    Raises WmsError with its place for what they cannot do.
    """
    return values.once(("", "travels"), lambda: _travels(values))


def _travels(values: Values) -> dict[str, Travel]:
    found: dict[str, Travel] = {}
    every = in_turn(values, tuple(_PLANS))
    for robot in dict.fromkeys(action.of for action in every):
        stands = base(values, robot)
        first = Spot(stands.position[0], stands.position[1], values.number(robot, "yaw"))
        acts = [action for action in every if action.of == robot]
        planned = _PLANS[values.spec.thing(robot).model](values, stands.position[2], first, acts)
        paces = [0.0, *(_passing(one, other) for one, other in pairwise(planned)), 0.0]
        for stretch, enters, leaves in zip(planned, paces, paces[1:], strict=False):
            _keeps_pace(values.spec.thing(robot).model, stretch, enters, leaves)
            found[stretch.action.name] = _written(stretch, stands.position[2], enters, leaves)
    return found


def _stretch(
    values: Values, action: Thing, length: float, at: Callable[[float], tuple[Spot, float]], flows: bool = False
) -> _Stretch:
    start = values.number(action.name, "start")
    if lasts(values, action) <= 0:
        raise ImpossibleValue(f"`{action.name}` takes no time", action.place, "give it a time above 0: `for 2 s`")
    return _Stretch(action, start, lasts(values, action), length, at, flows)


def _keeps_pace(model: str, stretch: _Stretch, enters: float, leaves: float) -> None:
    """Complain if somebody would have to be faster than such a thing is."""
    moments = [stretch.lasts * i / 16 for i in range(17)]
    ways = [gone(stretch.length, stretch.lasts, enters, leaves, moment) for moment in moments]
    fastest = max(b - a for a, b in pairwise(ways)) * 16 / stretch.lasts
    spins = stretch.action.verb in ("turn", "look") and model == "walker"
    most = SPINS if spins else FASTEST[model]
    if fastest > most:
        unit, scale = ("deg/s", 180 / math.pi) if spins else ("m/s", 1.0)
        raise ImpossibleValue(
            f"`{stretch.action.of}` would have to {'turn' if spins else 'go'} at {fastest * scale:.0f} {unit}, and "
            f"{model}s here do at most {most * scale:.0f}",
            stretch.action.place,
            f"give it some {math.ceil(10 * stretch.lasts * fastest / most) / 10:g} s",
        )


def _written(stretch: _Stretch, level: float, enters: float, leaves: float) -> Travel:
    """Many places of a stretch that is entered and left so fast (m/s)."""
    count = max(1, math.ceil(stretch.lasts * RATE))
    moments = tuple(stretch.lasts * i / count for i in range(count + 1))
    points, turns = [], []
    for moment in moments:
        far = gone(stretch.length, stretch.lasts, enters, leaves, moment)
        pose = _nodding(*stretch.at(min(max(far, 0.0), stretch.length)), level)
        (x, y, z), (a, b, c, d) = pose.position, pose.orientation
        points.append((round(x, DIGITS), round(y, DIGITS), round(z, DIGITS)))
        turns.append((round(a, DIGITS), round(b, DIGITS), round(c, DIGITS), round(d, DIGITS)))
    return Travel(moments, tuple(points), tuple(turns))


def _nodding(spot: Spot, pitch: float, level: float) -> Pose:
    """The pose of a robot at a place, tilted upwards about its neck."""
    turned, here = turn(spot.heading, -pitch), (spot.x, spot.y, level)
    if pitch == 0:
        return Pose(here, turned)
    return Pose(add(add(here, (0.0, 0.0, NECK)), rotate(turned, (0.0, 0.0, -NECK))), turned)


# ---------------------------------------------------------------- cars


def _driven(values: Values, level: float, spot: Spot, acts: Sequence[Thing]) -> list[_Stretch]:
    traffic, stretches = _traffic(values, acts[0].of), list[_Stretch]()
    standing = obstacles(values, level + BUMPERS[0], level + BUMPERS[1])
    for action in acts:
        before = stretches[-1] if stretches else None
        try:
            traffic.under(spot)
            legs = _legs(values, traffic, spot, action, before)
        except OffRoadError as error:
            problem = f"`{action.of}` cannot {action.verb} so: {error}"
            raise ImpossibleValue(problem, action.place, error.help) from None
        stretch = _stretch(values, action, sum(leg.length for leg in legs), partial(_on, legs), True)
        _keeps_clear(stretch, standing)
        stretches.append(stretch)
        spot = along(legs, stretch.length)
    return stretches


def _traffic(values: Values, robot: str) -> Traffic:
    names = values.references(robot, "roads") if values.has(robot, "roads") else ()
    roads = tuple(road(values, name) for name in names if values.there(name))
    side = 1 if values.text(robot, "keeps") == "left" else -1
    return Traffic(roads, values.number(robot, "lane"), side)


def _legs(values: Values, traffic: Traffic, spot: Spot, action: Thing, before: _Stretch | None) -> list[Leg]:
    """The way of a car during an action."""
    if action.verb == "forward":
        return traffic.forward(spot, values.number(action.name, "distance"))
    if action.verb == "stop":
        start = values.number(action.name, "start")
        if before is None or before.action.verb == "stop" or abs(before.start + before.lasts - start) > 1e-6:
            raise OffRoadError("it stands still by then", "let it stop while it drives: `after` what it does before")
        return traffic.forward(spot, before.pace * lasts(values, action) / 2)
    if action.verb == "go_to":
        place = values.pose(_goal(values, action)).position
        return traffic.go_to(spot, (place[0], place[1]))
    to = 1 if values.direction(action.name) == "left" else -1
    return traffic.turn(spot, to) if action.verb == "turn" else traffic.change_lane(spot, to)


def _goal(values: Values, action: Thing) -> str:
    """The object that somebody goes to. Raises WmsError with its place if it is not there."""
    goal = values.reference(action.name, "to")
    if not values.there(goal):
        raise ImpossibleValue(f"`{goal}` is not there, so nobody can go to it", action.place)
    return goal


def _on(legs: Sequence[Leg], far: float) -> tuple[Spot, float]:
    return along(legs, far), 0.0


def _passing(one: _Stretch, other: _Stretch) -> float:
    """How fast (m/s) a car goes on from one action to the next; a walker, and who waits between them, stands still."""
    waits = abs(one.start + one.lasts - other.start) > 1e-6
    if waits or not one.flows or one.action.verb == "stop":
        return 0.0
    return one.pace if other.action.verb == "stop" else min(one.pace, other.pace)


def _keeps_clear(stretch: _Stretch, standing: Sequence[Outline]) -> None:
    """Complain if the car would drive into something."""
    robot = stretch.action.of
    for i in range(math.ceil(stretch.length / LOOKS) + 1):
        spot, _ = stretch.at(min(i * LOOKS, stretch.length))
        corners = (spot.ahead(x * LONG / 2, y * WIDE / 2) for x in (-1, 1) for y in (-1, 1))
        car = Outline(robot, hull([(corner.x, corner.y) for corner in corners]))
        for other in standing:
            if math.dist(other.middle, (spot.x, spot.y)) < other.radius + LONG and car.meets(other):
                where = f"{i * LOOKS:.1f} m after `{stretch.action.name}` begins" if i else "where it starts"
                raise ImpossibleValue(
                    f"`{robot}` would drive into `{other.name}`, {where}",
                    stretch.action.place,
                    f"move `{other.name}` out of its way",
                )


# ---------------------------------------------------------------- walkers


def _walked(values: Values, level: float, spot: Spot, acts: Sequence[Thing]) -> list[_Stretch]:
    standing = obstacles(values, level + WALKERS[0], level + WALKERS[1])
    stretches, pitch = list[_Stretch](), 0.0
    for outline in standing:
        if outline.distance((spot.x, spot.y)) < GIRTH:
            walker = acts[0].of
            problem = f"`{walker}` stands less than {GIRTH * 100:g} cm from `{outline.name}`, or in it"
            raise ImpossibleValue(problem, values.place(walker, "at"), "place it further away")
    for action in acts:
        if action.verb in ("move", "back"):
            wanted, sign = values.number(action.name, "distance"), 1 if action.verb == "move" else -1
            way = Straight(spot, _free(Straight(spot, wanted, sign), standing), sign)
            stretch = _stretch(values, action, way.length, partial(_walking, way, pitch))
        elif action.verb == "go_to":
            goal = _goal(values, action)
            legs = legs_to(spot, around(values, goal), standing, GIRTH + CLEAR)
            if legs is None:
                problem = f"no way leads `{action.of}` to within reach of `{goal}`"
                raise ImpossibleValue(problem, action.place, "make room, or name something that can be reached")
            stretch = _stretch(values, action, sum(leg.length for leg in legs), partial(_finding, legs, pitch))
        elif action.verb == "turn":
            angle = values.number(action.name, "angle")
            side = 1 if values.direction(action.name) == "left" else -1
            stretch = _stretch(values, action, angle, partial(_turning, spot, pitch, side))
        else:
            up = values.number(action.name, "angle")
            stretch = _stretch(values, action, abs(up - pitch), partial(_looking, spot, pitch, up))
        stretches.append(stretch)
        spot, pitch = stretch.at(stretch.length)
    return stretches


def _walking(way: Straight, pitch: float, far: float) -> tuple[Spot, float]:
    return way.at(far), pitch


def _finding(legs: Sequence[Leg], pitch: float, far: float) -> tuple[Spot, float]:
    return along(legs, far), pitch


def _turning(spot: Spot, pitch: float, side: int, far: float) -> tuple[Spot, float]:
    return Spot(spot.x, spot.y, spot.heading + side * far), pitch


def _looking(spot: Spot, pitch: float, up: float, far: float) -> tuple[Spot, float]:
    return spot, pitch + math.copysign(far, up - pitch)


def _free(way: Straight, standing: Sequence[Outline]) -> float:
    """How far (m) a walker comes: all of its way, or until a little before what is in it, in whole millimetres.

    It goes as far at a time as nothing can be in between.
    """
    start, near = (way.start.x, way.start.y), list[Outline]()
    near += [o for o in standing if math.dist(o.middle, start) < way.length + o.radius + GIRTH]
    far = 0.0
    while far < way.length:
        spot = way.at(far)
        room = min((outline.distance((spot.x, spot.y)) for outline in near), default=math.inf) - GIRTH
        if room < 0:
            return math.floor(max(0.0, far - CLEAR) * 1000) / 1000
        far += max(room, SIDLES)
    return way.length


_PLANS: dict[str, Callable[[Values, float, Spot, Sequence[Thing]], list[_Stretch]]] = {
    "car": _driven,
    "walker": _walked,
}
"""Model of a robot -> what plans its actions in turn, given how high (m) the ground is, and where it stands."""
