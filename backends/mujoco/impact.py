"""Restitution in MuJoCo, which models contacts as damped springs: stiff enough that an impact lasts about 20 steps.

Units in this file are the time step and the impact speed. `INELASTIC`, `MAX_FREQUENCY`, `FRICTION_RATE` and
`SLIDING_RATE` were fitted to analytic impacts (drops, colliding balls, sliding boxes); `tests/physics` bounds their
errors.
"""

from __future__ import annotations

from functools import cache
from typing import NamedTuple

import numpy as np

from wmspec.sim.scene.model import Array, Friction

IMPEDANCE = 0.9999
SOLIMP = (IMPEDANCE, IMPEDANCE, 0.001, 0.5, 2.0)
TORSIONAL_FRICTION, ROLLING_FRICTION = 0.005, 0.0001  # required by the format, no effect at condim 3
MIN_RESTITUTION = 0.04  # approximate restitution of a critically damped impact


class Spring(NamedTuple):
    """Frequency * step, damping rate * step."""

    frequency: float
    damping: float


INELASTIC = Spring(0.02, 0.1)  # impacts without restitution
MAX_FREQUENCY = 0.15  # highest frequency of impacts with restitution
FRICTION_RATE = 0.2  # damping rate of friction: at least twice the normal rate, or impacts end before friction acts
SLIDING_RATE = (
    0.058  # the same without restitution, where bodies rather slide: RUB makes them hop, see `solreffriction`
)
_PHASES = (np.arange(64) + 0.5) / 64  # phases of the step at which the surface is reached
_LONGEST = 800


def constraint_solref(step: float) -> tuple[float, float]:
    """Return the `solref` of grips, loop closures and mimic joints: as stiff as the step (s) allows."""
    return -((0.1 / step) ** 2), -0.5 / step


def solref(pair: Friction, step: float) -> tuple[float, float]:
    """Return MuJoCo's `solref` in direct form (-stiffness, -damping) for the restitution of a pair; `step` in s."""
    frequency, damping = spring(round(pair.restitution, 4))
    return -((frequency / step * IMPEDANCE) ** 2), -damping / step * IMPEDANCE


def solreffriction(pair: Friction, step: float, led: bool) -> tuple[float, float]:
    """Return MuJoCo's `solreffriction` in direct form for the restitution of a pair; `step` in s.

    MuJoCo's friction cones are convex: a body sliding at speed v with friction m is lifted by m v times this rate per
    step of contact. A lower rate hops less, but creeps more on inclines and acts too late in short impacts. A body
    pushed by a kinematic one (`led`) must stick: at the lower rate it creeps aside by 1 % of its path.
    """
    return 0.0, -(SLIDING_RATE if pair.restitution <= MIN_RESTITUTION and not led else FRICTION_RATE) / step * IMPEDANCE


@cache
def spring(restitution: float) -> Spring:
    """Return the stiffest spring up to `MAX_FREQUENCY` with this `restitution` damped at most like `INELASTIC`."""
    if restitution <= MIN_RESTITUTION:
        return INELASTIC
    frequency = MAX_FREQUENCY * min(
        1.0, INELASTIC.damping / damping(restitution, MAX_FREQUENCY)
    )  # their ratio determines restitution
    return Spring(frequency, damping(restitution, frequency))


def damping(restitution: float, frequency: float) -> float:
    """Return the damping rate with this mean restitution over all phases."""
    low, high = -0.05, 1.0
    for _ in range(40):
        middle = (low + high) / 2
        if rebound(frequency**2, middle).mean() > restitution:
            low = middle
        else:
            high = middle
    return (low + high) / 2


def rebound(stiffness: float, damping: float) -> Array:
    """Return the speeds (64,) after a contact that only pushes, in semi-implicit Euler steps as in MuJoCo."""
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
