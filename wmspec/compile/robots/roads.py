"""Roads, which are objects that cars drive on: their lanes, and the ways from one to another."""

from __future__ import annotations

import math
from dataclasses import dataclass
from heapq import heappop, heappush
from typing import TYPE_CHECKING

from wmspec.compile.layout.geometry import pieces
from wmspec.compile.layout.solids import bounds
from wmspec.compile.robots.ways import Bend, Leg, Spot, Straight, Swerve
from wmspec.core.space import HERE, rotate

if TYPE_CHECKING:
    from wmspec.compile.layout.values import Values

LONG, WIDE = 4.2, 1.8  # m: a car
TIGHTEST = 4.5  # m: before and behind the corner of two lanes a car turns at least so wide
BEYOND = 2.0  # m: a turn ends so far behind the crossing, in its lane
SWERVES = 6.0  # how many times further than aside a car goes as it changes lanes
ALIGNED = math.radians(1)


@dataclass(frozen=True)
class Road:
    """A straight carriageway: its middle, its heading one way (rad), and half its length and width (m)."""

    name: str
    middle: Spot
    half_length: float
    half_width: float

    def seen(self, x: float, y: float) -> tuple[float, float]:
        """How far (m) along it a place is from its middle, and to the left."""
        cos, sin = math.cos(self.middle.heading), math.sin(self.middle.heading)
        dx, dy = x - self.middle.x, y - self.middle.y
        return (dx * cos + dy * sin, dy * cos - dx * sin)

    def away(self, x: float, y: float) -> float:
        """How far (m) from it a place is; 0 on it."""
        far, left = self.seen(x, y)
        return math.hypot(max(0.0, abs(far) - self.half_length), max(0.0, abs(left) - self.half_width))


class OffRoadError(Exception):
    """No car can drive so: why, and what helps."""

    def __init__(self, reason: str, help: str) -> None:
        super().__init__(reason)
        self.help = help


@dataclass(frozen=True)
class Traffic:
    """The `roads`, how wide a `lane` of them is (m), and the `side` that is kept to: 1 the left, -1 the right."""

    roads: tuple[Road, ...]
    lane: float
    side: int

    def under(self, spot: Spot) -> tuple[Road, int]:
        """The road that a car is on, and whether it goes its way (1) or the other (-1)."""
        for road in self.roads:
            far, left = road.seen(spot.x, spot.y)
            turned = math.remainder(spot.heading - road.middle.heading, math.pi)
            if abs(far) > road.half_length or abs(left) > road.half_width or abs(turned) > ALIGNED:
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
        """How many lanes there are each way."""
        return max(1, math.floor(road.half_width / self.lane + 1e-9))

    # ------------------------------------------------------------ what cars do

    def forward(self, spot: Spot, distance: float) -> list[Leg]:
        """On along the lane."""
        self._long_enough(spot, distance)
        return [Straight(spot, distance)]

    def change_lane(self, spot: Spot, to: int) -> list[Leg]:
        """Over to the middle of the next lane to the left (`to` 1) or right (-1)."""
        road, way = self.under(spot)
        offset = road.seen(spot.x, spot.y)[1] * way * self.side
        lane = math.floor(offset / self.lane) + to * self.side
        if not 0 <= lane < self.lanes(road):
            there = "left" if to > 0 else "right"
            raise OffRoadError(
                f"there is no lane for it on the {there} in `{road.name}`",
                f"make the road wider, or the lanes narrower: `lane:` is {self.lane:g} m",
            )
        aside = ((lane + 0.5) * self.lane - offset) * self.side
        self._long_enough(spot, SWERVES * abs(aside))
        return [Swerve(spot, SWERVES * abs(aside), aside)]

    def turn(self, spot: Spot, to: int) -> list[Leg]:
        """Into the next road to the left (`to` 1) or right (-1): from its lane into one of that, and on beyond it."""
        ahead = self._turns(spot, to)
        if not ahead:
            there = "left" if to > 0 else "right"
            raise OffRoadError(
                f"no road that it can turn into goes off to the {there} ahead of it",
                f"let it start {TIGHTEST:g} m or more before a crossing, and name that road in its `roads:`",
            )
        straight, bend, on = min(ahead, key=lambda legs: legs[0].length)
        return [straight, bend, on]

    def go_to(self, spot: Spot, place: tuple[float, float]) -> list[Leg]:
        """The shortest way to where the road that passes nearest to a place does so (E. W. Dijkstra, 1959)."""
        goal = min(self.roads, key=lambda road: road.away(*place))
        most = goal.half_length - LONG / 2
        far = min(most, max(-most, goal.seen(*place)[0]))
        waiting: list[tuple[float, int, list[Leg], Spot | None]] = [(0.0, 0, [], spot)]
        known, count = set[tuple[float, ...]](), 0
        while waiting:
            gone, _, legs, here = heappop(waiting)
            if here is None:
                return legs
            key = tuple(round(n, 6) for n in (here.x, here.y, math.cos(here.heading), math.sin(here.heading)))
            if key in known:
                continue
            known.add(key)
            road, way = self.under(here)
            ahead = (far - road.seen(here.x, here.y)[0]) * way
            further: list[tuple[Leg, ...]] = [turned for to in (1, -1) for turned in self._turns(here, to)]
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

    # ------------------------------------------------------------ by which means

    def _turns(self, spot: Spot, to: int) -> list[tuple[Straight, Bend, Straight]]:
        """The ways into all roads that go off ahead, to that side."""
        road, _ = self.under(spot)
        crossings = (self._crossing(road, spot, other, to) for other in self.roads if other is not road)
        return [found for found in crossings if found is not None]

    def _long_enough(self, spot: Spot, distance: float) -> None:
        road, _ = self.under(spot)
        end = spot.ahead(distance + LONG / 2)
        over = abs(road.seen(end.x, end.y)[0]) - road.half_length
        if over > 1e-9:
            raise OffRoadError(
                f"`{road.name}` ends {distance - over:.1f} m ahead of it",
                "let it drive less far, or make the road longer",
            )

    def _crossing(self, road: Road, spot: Spot, other: Road, to: int) -> tuple[Straight, Bend, Straight] | None:
        """The way into another road; None if that does not go off ahead, to that side."""
        across = math.sin(other.middle.heading - spot.heading)
        if abs(across) < math.sin(2 * ALIGNED):
            return None
        onward = other.middle.heading if across * to > 0 else other.middle.heading + math.pi
        angle = math.remainder(onward - spot.heading, 2 * math.pi)
        axes = Spot(road.middle.x, road.middle.y, spot.heading), Spot(other.middle.x, other.middle.y, onward)
        middle = _at(axes[0], _meeting(*axes))  # of the crossing
        way = math.cos(onward - other.middle.heading)
        end = other.seen(*middle)[0] * way + road.half_width / abs(math.sin(angle)) + BEYOND
        if abs(road.seen(*middle)[0]) > road.half_length or end + LONG / 2 > other.half_length:
            return None
        lane = (self.lanes(other) - 0.5) * self.lane if to == self.side else 0.5 * self.lane
        corner = _meeting(spot, axes[1].ahead(0.0, self.side * lane))
        edge = _meeting(spot, axes[1]) - other.half_width / abs(math.sin(angle))
        sharp = max(corner - edge, TIGHTEST)
        if corner < sharp:
            return None
        bend = Bend(spot.ahead(corner - sharp), sharp / math.tan(abs(angle) / 2), angle)
        left = bend.at(bend.length)
        far = other.seen(left.x, left.y)[0] * way
        on = Straight(Spot(left.x, left.y, onward), max(0.0, end - far))
        return Straight(spot, corner - sharp), bend, on


def _at(spot: Spot, far: float) -> tuple[float, float]:
    there = spot.ahead(far)
    return (there.x, there.y)


def _meeting(spot: Spot, line: Spot) -> float:
    """How far (m) ahead of a spot its line meets another."""
    cos, sin = math.cos(line.heading), math.sin(line.heading)
    away = (line.x - spot.x) * sin - (line.y - spot.y) * cos
    return away / math.sin(line.heading - spot.heading)


def road(values: Values, name: str) -> Road:
    """An object as a road: along the longer side of its box."""
    pose = values.pose(name)
    low, high = bounds(pieces(values, name), HERE)
    x, y, _ = pose.apply(((low[0] + high[0]) / 2, (low[1] + high[1]) / 2, 0.0))
    long = high[0] - low[0] >= high[1] - low[1]
    ahead = rotate(pose.orientation, (1.0, 0.0, 0.0) if long else (0.0, 1.0, 0.0))
    sizes = ((high[0] - low[0]) / 2, (high[1] - low[1]) / 2)
    return Road(name, Spot(x, y, math.atan2(ahead[1], ahead[0])), max(sizes), min(sizes))
