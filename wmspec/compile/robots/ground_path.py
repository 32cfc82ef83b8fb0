"""Paths on the ground: straight, curved, lane changes and turns in place, with speed profiles."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

METRES_PER_RADIAN = 0.5


@dataclass(frozen=True)
class Pose2D:
    """A position on the ground (m) and a heading (rad, anticlockwise from +x)."""

    x: float
    y: float
    heading: float

    def ahead(self, far: float, aside: float = 0.0) -> Pose2D:
        """Return the pose displaced forward and to the left (m)."""
        cos, sin = math.cos(self.heading), math.sin(self.heading)
        return Pose2D(self.x + far * cos - aside * sin, self.y + far * sin + aside * cos, self.heading)


@dataclass(frozen=True)
class Straight:
    """A straight segment; backwards if `sign` is -1."""

    start: Pose2D
    length: float
    sign: int = 1

    def at(self, far: float) -> Pose2D:
        """Return the pose at a distance (m)."""
        return self.start.ahead(self.sign * far)


@dataclass(frozen=True)
class Bend:
    """A circular arc of `radius` m and `angle` rad, positive to the left."""

    start: Pose2D
    radius: float
    angle: float

    @property
    def length(self) -> float:
        """Arc length (m)."""
        return self.radius * abs(self.angle)

    def at(self, far: float) -> Pose2D:
        """Return the pose at a distance (m)."""
        side = math.copysign(self.radius, self.angle)
        turned, middle = far / side, self.start.ahead(0.0, side)
        heading = self.start.heading + turned
        return Pose2D(middle.x + side * math.sin(heading), middle.y - side * math.cos(heading), heading)


@dataclass(frozen=True)
class Swerve:
    """A lane change by `aside` m (positive to the left) over `length` m ahead, with equal headings at both ends."""

    start: Pose2D
    length: float
    aside: float

    def at(self, far: float) -> Pose2D:
        """Return the pose at a distance (m) ahead, on a cubic between the two lines."""
        u = far / self.length
        place = self.start.ahead(far, self.aside * u * u * (3 - 2 * u))
        slope = 6 * self.aside * u * (1 - u) / self.length
        return Pose2D(place.x, place.y, self.start.heading + math.atan(slope))


@dataclass(frozen=True)
class Pivot:
    """A turn in place by `angle` rad (positive to the left); its length is METRES_PER_RADIAN per radian."""

    start: Pose2D
    angle: float

    @property
    def length(self) -> float:
        """Nominal length (m)."""
        return METRES_PER_RADIAN * abs(self.angle)

    def at(self, far: float) -> Pose2D:
        """Return the pose at a nominal distance (m)."""
        return Pose2D(
            self.start.x, self.start.y, self.start.heading + math.copysign(far / METRES_PER_RADIAN, self.angle)
        )


#: A segment of a path.
PathSegment = Straight | Bend | Swerve | Pivot


def pose_along(legs: Sequence[PathSegment], far: float) -> Pose2D:
    """Return the pose at a distance (m) along a path."""
    for leg in legs[:-1]:
        if far <= leg.length:
            return leg.at(far)
        far -= leg.length
    return legs[-1].at(min(far, legs[-1].length))


def arc_length_at(length: float, lasts: float, first: float, last: float, time: float) -> float:
    """Return the distance (m) covered at `time` (s): a cubic with the end speeds `first` and `last` (m/s).

    It is monotonic if both are at most three times the mean speed.
    """
    u = time / lasts
    eased = length * u * u * (3 - 2 * u)
    return eased + lasts * (first * u * (1 - u) ** 2 - last * u * u * (1 - u))
