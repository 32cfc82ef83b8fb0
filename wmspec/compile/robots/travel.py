"""Plans cars and walkers before the episode: positions and orientations over time.

A plan depends on initial poses only, not on later events.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import pairwise
from typing import TYPE_CHECKING

from wmspec.compile.layout.placement import base
from wmspec.compile.robots.ground_path import PathSegment, Pose2D, Straight, arc_length_at, pose_along
from wmspec.compile.robots.obstacles import Outline, hull, object_outlines, obstacles
from wmspec.compile.robots.roads import CAR_LENGTH, CAR_WIDTH, OffRoadError, Traffic, road
from wmspec.compile.robots.schedule import action_duration, actions_in_order
from wmspec.compile.robots.wayfinding import path_to
from wmspec.core.diagnostics import ImpossibleValue
from wmspec.core.space import Pose, Quaternion, Vector, add, from_ypr, rotate
from wmspec.lang.check.ir.ir import Entity

if TYPE_CHECKING:
    from wmspec.compile.layout.evaluator import Evaluator

SAMPLE_RATE = 30  # Hz
DECIMALS = 9  # for equal results on every processor
HEAD_JOINT = 1.2  # m: height of the joint about which a walker's head nods
WALKER_RADIUS = 0.25  # m
STOP_DISTANCE = 0.02  # m: between a walker that stops and the obstacle
MIN_STEP = 0.005  # m: of the search for obstacles
WALKER_HEIGHTS = (0.1, 1.7)  # m above the ground: obstacles of a walker reach between these
CAR_HEIGHTS = (0.2, 1.5)  # m above the ground: the same for a car
CHECK_INTERVAL = 0.2  # m: along the path of a car
MAX_SPEED = {"car": 50.0, "walker": 8.0}  # m/s: a car on a motorway, a sprinter
MAX_TURN_RATE = 4 * math.pi  # rad/s


@dataclass(frozen=True)
class Travel:
    """The motion of a robot during an action: `points` (m) and `turns` at `times` (s after its start)."""

    times: tuple[float, ...]
    points: tuple[Vector, ...]
    turns: tuple[Quaternion, ...]


@dataclass(frozen=True)
class _Segment:
    """The motion of one action: `at` returns the pose and the pitch (rad) at a distance within `length` (m or rad).

    A segment that `flows` continues into the next one without a halt.
    """

    action: Entity
    start: float
    duration: float
    length: float
    at: Callable[[float], tuple[Pose2D, float]]
    flows: bool = False

    @property
    def pace(self) -> float:
        """Mean speed."""
        return self.length / self.duration


def travels(values: Evaluator) -> dict[str, Travel]:
    """Return the motions of all cars and walkers, by the names of the actions.

    Raises WmsError with its location for infeasible actions.
    """
    return values.memoized(("", "travels"), lambda: _travels(values))


def _travels(values: Evaluator) -> dict[str, Travel]:
    found: dict[str, Travel] = {}
    every = actions_in_order(values, tuple(_PLANS))
    for robot in dict.fromkeys(action.of for action in every):
        stands = base(values, robot)
        first = Pose2D(stands.position[0], stands.position[1], values.number(robot, "yaw"))
        acts = [action for action in every if action.of == robot]
        planned = _PLANS[values.spec.thing(robot).model](values, stands.position[2], first, acts)
        paces = [0.0, *(_transition_speed(one, other) for one, other in pairwise(planned)), 0.0]
        for stretch, enters, leaves in zip(planned, paces, paces[1:], strict=False):
            _check_speed(values.spec.thing(robot).model, stretch, enters, leaves)
            found[stretch.action.name] = _sampled(stretch, stands.position[2], enters, leaves)
    return found


def _segment(
    values: Evaluator, action: Entity, length: float, at: Callable[[float], tuple[Pose2D, float]], flows: bool = False
) -> _Segment:
    start = values.number(action.name, "start")
    if action_duration(values, action) <= 0:
        raise ImpossibleValue(f"`{action.name}` takes no time", action.place, "give it a time above 0: `for 2 s`")
    return _Segment(action, start, action_duration(values, action), length, at, flows)


def _check_speed(model: str, stretch: _Segment, enters: float, leaves: float) -> None:
    """Raise if a robot would exceed its maximum speed."""
    moments = [stretch.duration * i / 16 for i in range(17)]
    ways = [arc_length_at(stretch.length, stretch.duration, enters, leaves, moment) for moment in moments]
    fastest = max(b - a for a, b in pairwise(ways)) * 16 / stretch.duration
    spins = stretch.action.verb in ("turn", "look") and model == "walker"
    most = MAX_TURN_RATE if spins else MAX_SPEED[model]
    if fastest > most:
        unit, scale = ("deg/s", 180 / math.pi) if spins else ("m/s", 1.0)
        raise ImpossibleValue(
            f"`{stretch.action.of}` would have to {'turn' if spins else 'go'} at {fastest * scale:.0f} {unit}, and "
            f"{model}s here do at most {most * scale:.0f}",
            stretch.action.place,
            f"give it some {math.ceil(10 * stretch.duration * fastest / most) / 10:g} s",
        )


def _sampled(stretch: _Segment, level: float, enters: float, leaves: float) -> Travel:
    """Return a segment, entered and left at these speeds (m/s), as samples."""
    count = max(1, math.ceil(stretch.duration * SAMPLE_RATE))
    moments = tuple(stretch.duration * i / count for i in range(count + 1))
    points, turns = [], []
    for moment in moments:
        far = arc_length_at(stretch.length, stretch.duration, enters, leaves, moment)
        pose = _tilted_pose(*stretch.at(min(max(far, 0.0), stretch.length)), level)
        (x, y, z), (a, b, c, d) = pose.position, pose.orientation
        points.append((round(x, DECIMALS), round(y, DECIMALS), round(z, DECIMALS)))
        turns.append((round(a, DECIMALS), round(b, DECIMALS), round(c, DECIMALS), round(d, DECIMALS)))
    return Travel(moments, tuple(points), tuple(turns))


def _tilted_pose(spot: Pose2D, pitch: float, level: float) -> Pose:
    """Return the pose of a robot, pitched upwards about its head joint."""
    turned, here = from_ypr(spot.heading, -pitch), (spot.x, spot.y, level)
    if pitch == 0:
        return Pose(here, turned)
    return Pose(add(add(here, (0.0, 0.0, HEAD_JOINT)), rotate(turned, (0.0, 0.0, -HEAD_JOINT))), turned)


def _at_path(legs: Sequence[PathSegment], pitch: float, far: float) -> tuple[Pose2D, float]:
    return pose_along(legs, far), pitch


# ---------------------------------------------------------------- cars


def _plan_car(values: Evaluator, level: float, spot: Pose2D, acts: Sequence[Entity]) -> list[_Segment]:
    """Return the segments of a car."""
    traffic, stretches = _traffic(values, acts[0].of), list[_Segment]()
    standing = obstacles(values, level + CAR_HEIGHTS[0], level + CAR_HEIGHTS[1])
    for action in acts:
        before = stretches[-1] if stretches else None
        try:
            traffic.road_at(spot)
            legs = _car_path(values, traffic, spot, action, before)
        except OffRoadError as error:
            problem = f"`{action.of}` cannot {action.verb} so: {error}"
            raise ImpossibleValue(problem, action.place, error.help) from None
        stretch = _segment(values, action, sum(leg.length for leg in legs), partial(_at_path, legs, 0.0), True)
        _check_clearance(stretch, standing)
        stretches.append(stretch)
        spot = pose_along(legs, stretch.length)
    return stretches


def _traffic(values: Evaluator, robot: str) -> Traffic:
    names = values.references(robot, "roads") if values.has(robot, "roads") else ()
    roads = tuple(road(values, name) for name in names if values.is_present(name))
    side = 1 if values.text(robot, "keeps") == "left" else -1
    return Traffic(roads, values.number(robot, "lane"), side)


def _car_path(
    values: Evaluator, traffic: Traffic, spot: Pose2D, action: Entity, before: _Segment | None
) -> list[PathSegment]:
    """Return the path of a car during an action."""
    if action.verb == "forward":
        return traffic.forward(spot, values.number(action.name, "distance"))
    if action.verb == "stop":
        start = values.number(action.name, "start")
        if before is None or before.action.verb == "stop" or abs(before.start + before.duration - start) > 1e-6:
            raise OffRoadError("it stands still by then", "let it stop while it drives: `after` what it does before")
        return traffic.forward(spot, before.pace * action_duration(values, action) / 2)
    if action.verb == "go_to":
        place = values.pose(_goal(values, action)).position
        return traffic.go_to(spot, (place[0], place[1]))
    to = 1 if values.direction(action.name) == "left" else -1
    return traffic.turn(spot, to) if action.verb == "turn" else traffic.change_lane(spot, to)


def _goal(values: Evaluator, action: Entity) -> str:
    """Return the object that a robot goes to. Raises WmsError with its location if it is absent."""
    goal = values.reference(action.name, "to")
    if not values.is_present(goal):
        raise ImpossibleValue(f"`{goal}` is absent, so no robot can go to it", action.place)
    return goal


def _transition_speed(one: _Segment, other: _Segment) -> float:
    """Return the speed (m/s) between two actions: 0 for walkers and after a pause."""
    waits = abs(one.start + one.duration - other.start) > 1e-6
    if waits or not one.flows or one.action.verb == "stop":
        return 0.0
    return one.pace if other.action.verb == "stop" else min(one.pace, other.pace)


def _check_clearance(stretch: _Segment, standing: Sequence[Outline]) -> None:
    """Raise if the car would hit something."""
    robot = stretch.action.of
    for i in range(math.ceil(stretch.length / CHECK_INTERVAL) + 1):
        spot, _ = stretch.at(min(i * CHECK_INTERVAL, stretch.length))
        corners = (spot.ahead(x * CAR_LENGTH / 2, y * CAR_WIDTH / 2) for x in (-1, 1) for y in (-1, 1))
        car = Outline(robot, hull([(corner.x, corner.y) for corner in corners]))
        for other in standing:
            if math.dist(other.middle, (spot.x, spot.y)) < other.radius + CAR_LENGTH and car.meets(other):
                where = f"{i * CHECK_INTERVAL:.1f} m after `{stretch.action.name}` begins" if i else "where it starts"
                raise ImpossibleValue(
                    f"`{robot}` would drive into `{other.name}`, {where}",
                    stretch.action.place,
                    f"move `{other.name}` out of its way",
                )


# ---------------------------------------------------------------- walkers


def _plan_walker(values: Evaluator, level: float, spot: Pose2D, acts: Sequence[Entity]) -> list[_Segment]:
    """Return the segments of a walker."""
    standing = obstacles(values, level + WALKER_HEIGHTS[0], level + WALKER_HEIGHTS[1])
    stretches, pitch = list[_Segment](), 0.0
    for outline in standing:
        if outline.distance((spot.x, spot.y)) < WALKER_RADIUS:
            walker = acts[0].of
            problem = f"`{walker}` stands less than {WALKER_RADIUS * 100:g} cm from `{outline.name}`, or in it"
            raise ImpossibleValue(problem, values.source_location(walker, "at"), "place it further away")
    for action in acts:
        if action.verb in ("move", "back"):
            distance, sign = values.number(action.name, "distance"), 1 if action.verb == "move" else -1
            way = Straight(spot, _free_distance(Straight(spot, distance, sign), standing), sign)
            stretch = _segment(values, action, way.length, partial(_at_path, (way,), pitch))
        elif action.verb == "go_to":
            goal = _goal(values, action)
            legs = path_to(spot, object_outlines(values, goal), standing, WALKER_RADIUS + STOP_DISTANCE)
            if legs is None:
                problem = f"no way leads `{action.of}` to within reach of `{goal}`"
                raise ImpossibleValue(problem, action.place, "make room, or name something that can be reached")
            stretch = _segment(values, action, sum(leg.length for leg in legs), partial(_at_path, legs, pitch))
        elif action.verb == "turn":
            angle = values.number(action.name, "angle")
            side = 1 if values.direction(action.name) == "left" else -1
            stretch = _segment(values, action, angle, partial(_at_turn, spot, pitch, side))
        else:
            up = values.number(action.name, "angle")
            stretch = _segment(values, action, abs(up - pitch), partial(_at_nod, spot, pitch, up))
        stretches.append(stretch)
        spot, pitch = stretch.at(stretch.length)
    return stretches


def _at_turn(spot: Pose2D, pitch: float, side: int, far: float) -> tuple[Pose2D, float]:
    return Pose2D(spot.x, spot.y, spot.heading + side * far), pitch


def _at_nod(spot: Pose2D, pitch: float, up: float, far: float) -> tuple[Pose2D, float]:
    return spot, pitch + math.copysign(far, up - pitch)


def _free_distance(way: Straight, standing: Sequence[Outline]) -> float:
    """Return how far (m) a walker gets: the whole path, or up to the first obstacle, in whole millimetres.

    Each step is as long as the distance to the nearest obstacle permits.
    """
    start, near = (way.start.x, way.start.y), list[Outline]()
    near += [o for o in standing if math.dist(o.middle, start) < way.length + o.radius + WALKER_RADIUS]
    far = 0.0
    while far < way.length:
        spot = way.at(far)
        room = min((outline.distance((spot.x, spot.y)) for outline in near), default=math.inf) - WALKER_RADIUS
        if room < 0:
            return math.floor(max(0.0, far - STOP_DISTANCE) * 1000) / 1000
        far += max(room, MIN_STEP)
    return way.length


_PLANS: dict[str, Callable[[Evaluator, float, Pose2D, Sequence[Entity]], list[_Segment]]] = {
    "car": _plan_car,
    "walker": _plan_walker,
}
"""Planner for each robot model, given the ground's height (m), the start and the actions in order."""
