"""Directions as numbers modulo a full turn: 179 and -179 degrees differ by 2 degrees."""

from __future__ import annotations

import math

#: An angle (rad) this close above -pi counts as pi.
ROUNDING = 1e-6


class Bearing(float):
    """A direction about one axis (rad), in (-pi, pi]. Sums and differences are directions too."""

    def __new__(cls, angle: float) -> Bearing:
        """Return the direction of an angle (rad) of any size."""
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
