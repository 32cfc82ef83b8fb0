"""Bounds of moments of inertia: those of a body of mass m within distance r of its centre of mass are at most m r²."""

from __future__ import annotations

import math
from collections.abc import Iterable
from itertools import product

#: Radius of gyration relative to the distance of the farthest point of the geometry from the centre of mass: above the
#: first it is reported, above the second replaced. Both exceed 1, since the geometry may be simpler than the body.
MAX_GYRATION, ABSURD_GYRATION = 2.0, 10.0


def gyration_excess(mass: float, moments: Iterable[float], reach: float) -> float:
    """Return the largest moment (kg m²) relative to `mass` times the squared `reach` (m); 0 for a reach of 0."""
    return float(max(moments)) / (mass * reach**2) if reach > 0 else 0.0


def excess_text(times: float) -> str:
    """Return the words for an excess."""
    return f"its inertia is {times:.2g} times the largest that a body of its mass and size can have"


def is_implausible(times: float) -> bool:
    """Whether an excess is reported."""
    return times > MAX_GYRATION**2


def is_impossible(times: float) -> bool:
    """Whether the moments are replaced by those of the shapes."""
    return times > ABSURD_GYRATION**2


def farthest_corner(low: Iterable[float], high: Iterable[float], point: Iterable[float]) -> float:
    """Return the distance (m) of the farthest corner of a box from a point."""
    middle = tuple(point)
    return max(math.dist(corner, middle) for corner in product(*zip(low, high, strict=True)))
