"""Servos of MuJoCo: actuators whose force is affine in the position and velocity of a joint."""

from __future__ import annotations

import math
from collections.abc import Sequence

from wmspec.sim.scene.model import Drive


class UnsupportedActuator(Exception):
    """An actuator that is no drive; the text continues `an actuator`."""


def servo(
    gain: float,
    bias: Sequence[float],
    gear: float,
    control: tuple[float, float] | None = None,
    force: tuple[float, float] | None = None,
) -> Drive:
    """Return the drive of an actuator with the force `gain` u + `bias`[0] + `bias`[1] length + `bias`[2] velocity.

    Its control u is 0, or the nearest value of the range `control`; `force` is the range of its force. Length and force
    are those of the joint times and over `gear`. SI units and radians. Raises UnsupportedActuator.
    """
    if gear == 0:
        raise UnsupportedActuator("with a gear of 0 moves nothing")
    if not (bias[1] or bias[2]):
        raise UnsupportedActuator("that is no position or velocity actuator needs a control")
    if bias[1] > 0 or bias[2] > 0:
        raise UnsupportedActuator("that pushes away from its target is not supported")
    u = min(max(0.0, control[0]), control[1]) if control else 0.0
    stiffness, damping, pushed = -bias[1] * gear**2, -bias[2] * gear**2, (gain * u + bias[0]) * gear
    most = min(-force[0], force[1]) * abs(gear) if force else math.inf
    if most <= 0:
        raise UnsupportedActuator("that pulls one way only is not supported")
    target = pushed / stiffness if stiffness else 0.0
    speed = pushed / damping if damping and not stiffness else 0.0
    return Drive(stiffness + 0.0, damping + 0.0, target + 0.0, speed + 0.0, most)


def combined(first: Drive | None, second: Drive) -> Drive:
    """Return the sum of two drives of a joint; the smaller force limit holds for it. Raises UnsupportedActuator."""
    if first is None or not (first.stiffness or first.damping):
        return second
    if first.weightless:
        raise UnsupportedActuator("beside a drive by acceleration is not supported")
    stiffness, damping = first.stiffness + second.stiffness, first.damping + second.damping
    target = (first.stiffness * first.target + second.stiffness * second.target) / stiffness if stiffness else 0.0
    speed = (first.damping * first.velocity + second.damping * second.velocity) / damping if damping else 0.0
    return Drive(stiffness, damping, target, speed, min(first.max_force, second.max_force))


def shares_limit(first: Drive | None, second: Drive) -> bool:
    """Whether the sum of two drives limits the force of both, though only one has that limit."""
    acts = first is not None and bool(first.stiffness or first.damping)
    return acts and math.isfinite(min(first.max_force if first else math.inf, second.max_force))


SHARED_LIMIT = "the force limit of an actuator beside a spring or damper of its joint is not supported"
"""What is reported where limits are shared."""
