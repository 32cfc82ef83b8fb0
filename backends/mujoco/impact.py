"""MuJoCo has no restitution: a contact is a damped spring, here stiff enough that an impact lasts about twenty steps.

Units of this file: one time step, the speed of impact. The numbers in `SOFT`, `STIFF`, `RUB` and `SLIDE` were found by
comparison with analytic impacts (drops, collisions of balls, slid boxes): their errors are bounded in `tests/physics`.
"""

from __future__ import annotations

from functools import cache
from typing import NamedTuple

import numpy as np

from wmspec.sim.scene.model import Array, Friction

IMPEDANCE = 0.9999
LOWEST = 0.04  # a critically damped impact still has about this restitution


class Spring(NamedTuple):
    """Frequency times step, damping rate times step."""

    frequency: float
    damping: float


SOFT = Spring(0.02, 0.1)  # for impacts without restitution
STIFF = 0.15  # the highest frequency of those with
RUB = 0.2  # friction's damping rate: twice the normal one at least, or impacts are over before friction has acted
SLIDE = 0.058  # the same without restitution, where bodies rather slide: RUB makes them hop, see `solreffriction`
_PHASES = (np.arange(64) + 0.5) / 64  # where in the step the surface is met
_LONGEST = 800


def solref(pair: Friction, step: float) -> tuple[float, float]:
    """MuJoCo's `solref` in its direct form (-stiffness, -damping) for a pair's restitution; `step` in s."""
    frequency, damping = spring(round(pair.restitution, 4))
    return -((frequency / step * IMPEDANCE) ** 2), -damping / step * IMPEDANCE


def solreffriction(pair: Friction, step: float, led: bool) -> tuple[float, float]:
    """MuJoCo's `solreffriction` in its direct form for a pair's restitution; `step` in s.

    Its cones of friction are convex: what slides at speed v with friction m is thrown up with m v times this rate in
    every step that it touches. A lower rate hops less, but creeps more on inclines, and acts too late in short impacts.
    What is `led`, as by a hand whose motion is given, rather sticks: at the lower rate it creeps aside, 1 % of its way.
    """
    return 0.0, -(SLIDE if pair.restitution <= LOWEST and not led else RUB) / step * IMPEDANCE


@cache
def spring(restitution: float) -> Spring:
    """The stiffest spring, up to `STIFF`, that returns `restitution` and isn't damped faster than `SOFT`."""
    if restitution <= LOWEST:
        return SOFT
    frequency = STIFF * min(1.0, SOFT.damping / damping(restitution, STIFF))  # the ratio of the two gives restitution
    return Spring(frequency, damping(restitution, frequency))


def damping(restitution: float, frequency: float) -> float:
    """The damping rate with which an impact returns `restitution` of its speed, on average over the phases."""
    low, high = -0.05, 1.0
    for _ in range(40):
        middle = (low + high) / 2
        if rebound(frequency**2, middle).mean() > restitution:
            low = middle
        else:
            high = middle
    return (low + high) / 2


def rebound(stiffness: float, damping: float) -> Array:
    """The speeds (64,) after a contact that pushes, never pulls: semi-implicit Euler steps, as MuJoCo makes them."""
    depth, speed = -_PHASES.copy(), -np.ones_like(_PHASES)
    inside = np.ones_like(_PHASES, bool)
    for _ in range(_LONGEST):
        push = np.where(inside, np.maximum(0.0, -damping * speed - stiffness * depth), 0.0)
        speed = speed + push
        depth = np.where(inside, depth + speed, depth)
        inside &= (depth < 0) & ((push > 0) | (speed <= 0))
        if not inside.any():
            break
    return np.maximum(speed, 0.0)
