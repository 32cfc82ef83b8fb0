"""Directions as numbers: the same after a whole turn, so that 179 and -179 degrees are 2 degrees apart."""

from __future__ import annotations

import math

#: An angle (rad) that is so little above -pi is pi.
ROUNDING = 1e-6


class Bearing(float):
    """A direction about one axis (rad), in (-pi, pi]. What is added to it or taken away leads to another direction."""

    def __new__(cls, angle: float) -> Bearing:
        """The direction that an angle (rad) of any size says."""
        turned = math.remainder(angle, 2 * math.pi)
        return super().__new__(cls, math.pi if turned < ROUNDING - math.pi else turned)

    def __add__(self, angle: float) -> Bearing:
        return Bearing(float(self) + float(angle))

    __radd__ = __add__

    def __sub__(self, angle: float) -> Bearing:
        return Bearing(float(self) - float(angle))

    def __rsub__(self, angle: float) -> Bearing:
        return Bearing(float(angle) - float(self))

    def __neg__(self) -> Bearing:
        return Bearing(-float(self))
