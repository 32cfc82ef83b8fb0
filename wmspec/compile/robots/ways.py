"""Ways over the ground, in pieces: straight, along a bend, over to a side; and how fast they are gone."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

PIVOTS = 0.5  # m


@dataclass(frozen=True)
class Spot:
    """A place on the ground (m) and a heading (rad, anticlockwise from +x)."""

    x: float
    y: float
    heading: float

    def ahead(self, far: float, aside: float = 0.0) -> Spot:
        """So far (m) ahead of it, and to its left."""
        cos, sin = math.cos(self.heading), math.sin(self.heading)
        return Spot(self.x + far * cos - aside * sin, self.y + far * sin + aside * cos, self.heading)


class Leg(Protocol):
    """A piece of a way."""

    @property
    def length(self) -> float:
        """How long (m) it is."""

    def at(self, far: float) -> Spot:
        """Where it leads after so far (m)."""


@dataclass(frozen=True)
class Straight:
    """Straight ahead; backwards where `sign` is -1."""

    start: Spot
    length: float
    sign: int = 1

    def at(self, far: float) -> Spot:
        """So far ahead, or back."""
        return self.start.ahead(self.sign * far)


@dataclass(frozen=True)
class Bend:
    """A part of a circle of `radius` m, by an `angle` (rad) to the left, or below 0 to the right."""

    start: Spot
    radius: float
    angle: float

    @property
    def length(self) -> float:
        """That of the arc."""
        return self.radius * abs(self.angle)

    def at(self, far: float) -> Spot:
        """So far around."""
        side = math.copysign(self.radius, self.angle)
        turned, middle = far / side, self.start.ahead(0.0, side)
        heading = self.start.heading + turned
        return Spot(middle.x + side * math.sin(heading), middle.y - side * math.cos(heading), heading)


@dataclass(frozen=True)
class Swerve:
    """Over to the left by `aside` m, or below 0 to the right, as it goes `length` m ahead; it ends as it is headed."""

    start: Spot
    length: float
    aside: float

    def at(self, far: float) -> Spot:
        """So far ahead, on a cubic between the two lines."""
        u = far / self.length
        place = self.start.ahead(far, self.aside * u * u * (3 - 2 * u))
        slope = 6 * self.aside * u * (1 - u) / self.length
        return Spot(place.x, place.y, self.start.heading + math.atan(slope))


@dataclass(frozen=True)
class Pivot:
    """On the spot by an `angle` (rad) to the left, or below 0 to the right, which counts as `PIVOTS` m a radian."""

    start: Spot
    angle: float

    @property
    def length(self) -> float:
        """How long (m) it counts."""
        return PIVOTS * abs(self.angle)

    def at(self, far: float) -> Spot:
        """So far turned."""
        return Spot(self.start.x, self.start.y, self.start.heading + math.copysign(far / PIVOTS, self.angle))


def along(legs: Sequence[Leg], far: float) -> Spot:
    """Where a way leads after so far (m)."""
    for leg in legs[:-1]:
        if far <= leg.length:
            return leg.at(far)
        far -= leg.length
    return legs[-1].at(min(far, legs[-1].length))


def gone(length: float, lasts: float, first: float, last: float, time: float) -> float:
    """How far (m) somebody has come by `time` (s) who goes a `length` in `lasts` s: a cubic with these end speeds.

    It never goes back if both are at most three times the mean speed.
    """
    u = time / lasts
    eased = length * u * u * (3 - 2 * u)
    return eased + lasts * (first * u * (1 - u) ** 2 - last * u * u * (1 - u))
