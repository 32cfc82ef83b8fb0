"""Turns as files and the language say them: roll, pitch and yaw, where scenes have quaternions."""

from __future__ import annotations

import math

import numpy as np

from wmspec.sim.scene.model import Array, Pose
from wmspec.sim.scene.model.transform import multiply, rotation, turning

X, Y, Z = np.eye(3)

#: Less than this is rounding (m, rad).
_NOTHING = 1e-12


def posed(xyz: tuple[float, ...] = (0.0, 0.0, 0.0), rpy: tuple[float, ...] = (0.0, 0.0, 0.0)) -> Pose:
    """A frame at a point, turned by roll, pitch and yaw about the axes that stand still, in this order."""
    roll, pitch, yaw = rpy
    turn = multiply(turning(yaw * Z), multiply(turning(pitch * Y), turning(roll * X)))
    return Pose(np.array(xyz, float), turn)


def clean(numbers: Array) -> tuple[float, ...]:
    """Numbers without the rounding that turns have left."""
    return tuple(0.0 if abs(x) < _NOTHING else float(x) for x in numbers)


def angles(orientation: Array) -> tuple[float, float, float]:
    """Yaw, pitch and roll (rad) of a unit quaternion (4,)."""
    axes = rotation(orientation)
    level = math.hypot(axes[0, 0], axes[1, 0])
    pitch = math.atan2(-axes[2, 0], level)
    if level < 1e-9:  # it looks straight up or down, where yaw and roll are the same turn
        yaw, roll = math.atan2(-axes[0, 1], axes[1, 1]), 0.0
    else:
        yaw, roll = math.atan2(axes[1, 0], axes[0, 0]), math.atan2(axes[2, 1], axes[2, 2])
    yaw, pitch, roll = clean(np.array((yaw, pitch, roll)))
    return yaw, pitch, roll
