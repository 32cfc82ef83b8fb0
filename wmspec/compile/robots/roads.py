"""Roads and their lanes, and the paths of cars on them."""

from __future__ import annotations

import math
from dataclasses import dataclass
from heapq import heappop, heappush
from typing import TYPE_CHECKING

from wmspec.compile.layout.geometry import pieces
from wmspec.compile.layout.solids import bounds
from wmspec.compile.robots.ground_path import Bend, PathSegment, Pose2D, Straight, Swerve
from wmspec.core.space import IDENTITY, rotate

if TYPE_CHECKING:
    from wmspec.compile.layout.evaluator import Evaluator

CAR_LENGTH, CAR_WIDTH = 4.2, 1.8  # m
MIN_CORNER_DISTANCE = 4.5  # m: of a turn's ends from the corner of two lanes
EXIT_LENGTH = 2.0  # m: straight part of a turn behind the crossing
LANE_CHANGE_RATIO = 6.0  # length of a lane change per lateral displacement
MAX_HEADING_ERROR = math.radians(1)


@dataclass(frozen=True)
class Road:
    """A straight carriageway: centre, heading (rad), and half length and half width (m)."""

    name: str
    middle: Pose2D
    half_length: float
    half_width: float

    def to_local(self, x: float, y: float) -> tuple[float, float]:
        """Return how far (m) a place is from the centre along the road, and to the left."""
        cos, sin = math.cos(self.middle.heading), math.sin(self.middle.heading)
        dx, dy = x - self.middle.x, y - self.middle.y
        return (dx * cos + dy * sin, dy * cos - dx * sin)

    def distance_to(self, x: float, y: float) -> float:
        """Return the distance (m) of a place from the road; 0 on it."""
        far, left = self.to_local(x, y)
        return math.hypot(max(0.0, abs(far) - self.half_length), max(0.0, abs(left) - self.half_width))


class OffRoadError(Exception):
    """No car can drive like this: reason and remedy."""

    def __init__(self, reason: str, help: str) -> None:
        super().__init__(reason)
        self.help = help


@dataclass(frozen=True)
class Traffic:
    """The `roads`, the width of a `lane` (m), and the driving `side`: 1 is left, -1 is right."""

    roads: tuple[Road, ...]
    lane: float
    side: int

    def road_at(self, spot: Pose2D) -> tuple[Road, int]:
        """Return the road of a car, and whether the car follows its direction (1) or the opposite (-1)."""
        for road in self.roads:
            far, left = road.to_local(spot.x, spot.y)
            turned = math.remainder(spot.heading - road.middle.heading, math.pi)
            if abs(far) > road.half_length or abs(left) > road.half_width or abs(turned) > MAX_HEADING_ERROR:
                continue
            way = 1 if math.cos(spot.heading - road.middle.heading) > 0 else -1
            if left * way * self.side < 0:
                keeps = "left" if self.side > 0 else "right"
                raise OffRoadError(
                    f"it would stand on the wrong side of `{road.name}`",
                    f"move it to the {keeps} of the middle, turn it round, or say which side it `keeps:`",
                )
            return road, way
        named = ", ".join(f"`{road.name}`" for road in self.roads)
        raise OffRoadError(
            f"it is headed along none of its roads ({named})" if named else "it has no roads",
            "place it on a road, its `yaw:` along that" if named else "say `roads: [street, ...]`",
        )

    def lanes(self, road: Road) -> int:
        """Return the number of lanes per direction."""
        return max(1, math.floor(road.half_width / self.lane + 1e-9))

    # ------------------------------------------------------------ actions

    def forward(self, spot: Pose2D, distance: float) -> list[PathSegment]:
        """Return the path straight along the lane."""
        self._long_enough(spot, distance)
        return [Straight(spot, distance)]

    def change_lane(self, spot: Pose2D, to: int) -> list[PathSegment]:
        """Return the path to the centre of the next lane to the left (`to` 1) or right (-1)."""
        road, way = self.road_at(spot)
        offset = road.to_local(spot.x, spot.y)[1] * way * self.side
        lane = math.floor(offset / self.lane) + to * self.side
        if not 0 <= lane < self.lanes(road):
            there = "left" if to > 0 else "right"
            raise OffRoadError(
                f"there is no lane for it on the {there} in `{road.name}`",
                f"make the road wider, or the lanes narrower: `lane:` is {self.lane:g} m",
            )
        aside = ((lane + 0.5) * self.lane - offset) * self.side
        self._long_enough(spot, LANE_CHANGE_RATIO * abs(aside))
        return [Swerve(spot, LANE_CHANGE_RATIO * abs(aside), aside)]

    def turn(self, spot: Pose2D, to: int) -> list[PathSegment]:
        """Return the path into the next road to the left (`to` 1) or right (-1), past the crossing."""
        ahead = self._turns(spot, to)
        if not ahead:
            there = "left" if to > 0 else "right"
            raise OffRoadError(
                f"no road that it can turn into goes off to the {there} ahead of it",
                f"let it start {MIN_CORNER_DISTANCE:g} m or more before a crossing, and name that road in its `roads:`",
            )
        straight, bend, on = min(ahead, key=lambda legs: legs[0].length)
        return [straight, bend, on]

    def go_to(self, spot: Pose2D, place: tuple[float, float]) -> list[PathSegment]:
        """Return the shortest path to the point of the nearest road closest to a place (E. W. Dijkstra, 1959)."""
        goal = min(self.roads, key=lambda road: road.distance_to(*place))
        most = goal.half_length - CAR_LENGTH / 2
        far = min(most, max(-most, goal.to_local(*place)[0]))
        waiting: list[tuple[float, int, list[PathSegment], Pose2D | None]] = [(0.0, 0, [], spot)]
        known, count = set[tuple[float, ...]](), 0
        while waiting:
            gone, _, legs, here = heappop(waiting)
            if here is None:
                return legs
            key = tuple(round(n, 6) for n in (here.x, here.y, math.cos(here.heading), math.sin(here.heading)))
            if key in known:
                continue
            known.add(key)
            road, way = self.road_at(here)
            ahead = (far - road.to_local(here.x, here.y)[0]) * way
            further: list[tuple[PathSegment, ...]] = [turned for to in (1, -1) for turned in self._turns(here, to)]
            further += [(Straight(here, ahead),)] if road is goal and ahead >= 0 else []
            for more in further:
                count += 1
                length = gone + sum(leg.length for leg in more)
                end = None if len(more) == 1 else more[-1].at(more[-1].length)
                heappush(waiting, (length, count, [*legs, *more], end))
        raise OffRoadError(
            f"no way leads to where `{goal.name}` is nearest to that without turning round",
            "let it start further away, or headed the other way",
        )

    # ------------------------------------------------------------ steps

    def _turns(self, spot: Pose2D, to: int) -> list[tuple[Straight, Bend, Straight]]:
        """Return the turns into all roads that branch off ahead on that side."""
        road, _ = self.road_at(spot)
        crossings = (self._crossing(road, spot, other, to) for other in self.roads if other is not road)
        return [found for found in crossings if found is not None]

    def _long_enough(self, spot: Pose2D, distance: float) -> None:
        road, _ = self.road_at(spot)
        end = spot.ahead(distance + CAR_LENGTH / 2)
        over = abs(road.to_local(end.x, end.y)[0]) - road.half_length
        if over > 1e-9:
            raise OffRoadError(
                f"`{road.name}` ends {distance - over:.1f} m ahead of it",
                "let it drive less far, or make the road longer",
            )

    def _crossing(self, road: Road, spot: Pose2D, other: Road, to: int) -> tuple[Straight, Bend, Straight] | None:
        """Return the turn into another road, or None if the road does not branch off ahead on that side."""
        across = math.sin(other.middle.heading - spot.heading)
        if abs(across) < math.sin(2 * MAX_HEADING_ERROR):
            return None
        onward = other.middle.heading if across * to > 0 else other.middle.heading + math.pi
        angle = math.remainder(onward - spot.heading, 2 * math.pi)
        axes = Pose2D(road.middle.x, road.middle.y, spot.heading), Pose2D(other.middle.x, other.middle.y, onward)
        middle = axes[0].ahead(_distance_to_line(*axes))  # crossing of the lane centres
        way = math.cos(onward - other.middle.heading)
        end = other.to_local(middle.x, middle.y)[0] * way + road.half_width / abs(math.sin(angle)) + EXIT_LENGTH
        if abs(road.to_local(middle.x, middle.y)[0]) > road.half_length or end + CAR_LENGTH / 2 > other.half_length:
            return None
        lane = (self.lanes(other) - 0.5) * self.lane if to == self.side else 0.5 * self.lane
        corner = _distance_to_line(spot, axes[1].ahead(0.0, self.side * lane))
        edge = _distance_to_line(spot, axes[1]) - other.half_width / abs(math.sin(angle))
        sharp = max(corner - edge, MIN_CORNER_DISTANCE)
        if corner < sharp:
            return None
        bend = Bend(spot.ahead(corner - sharp), sharp / math.tan(abs(angle) / 2), angle)
        left = bend.at(bend.length)
        far = other.to_local(left.x, left.y)[0] * way
        on = Straight(Pose2D(left.x, left.y, onward), max(0.0, end - far))
        return Straight(spot, corner - sharp), bend, on


def _distance_to_line(spot: Pose2D, line: Pose2D) -> float:
    """Return the distance (m) ahead at which the line of a pose meets another line."""
    cos, sin = math.cos(line.heading), math.sin(line.heading)
    away = (line.x - spot.x) * sin - (line.y - spot.y) * cos
    return away / math.sin(line.heading - spot.heading)


def road(values: Evaluator, name: str) -> Road:
    """Return an object as a road along the longer side of its box."""
    pose = values.pose(name)
    low, high = bounds(pieces(values, name), IDENTITY)
    x, y, _ = pose.apply(((low[0] + high[0]) / 2, (low[1] + high[1]) / 2, 0.0))
    long = high[0] - low[0] >= high[1] - low[1]
    ahead = rotate(pose.orientation, (1.0, 0.0, 0.0) if long else (0.0, 1.0, 0.0))
    sizes = ((high[0] - low[0]) / 2, (high[1] - low[1]) / 2)
    return Road(name, Pose2D(x, y, math.atan2(ahead[1], ahead[0])), max(sizes), min(sizes))
