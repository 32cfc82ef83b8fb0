"""Converts orientations between roll, pitch, yaw (files, language) and quaternions (scenes)."""

from __future__ import annotations

import math

import numpy as np

from wmspec.sim.scene.model import Array, Pose
from wmspec.sim.scene.model.transform import from_rotation_vector, multiply, rotation

X, Y, Z = np.eye(3)

#: Smaller values are rounding errors (m, rad).
_ROUNDING = 1e-12


def pose_from_rpy(xyz: tuple[float, ...] = (0.0, 0.0, 0.0), rpy: tuple[float, ...] = (0.0, 0.0, 0.0)) -> Pose:
    """Return a pose with a rotation by roll, pitch and yaw about the fixed axes, in this order."""
    roll, pitch, yaw = rpy
    turn = multiply(
        from_rotation_vector(yaw * Z), multiply(from_rotation_vector(pitch * Y), from_rotation_vector(roll * X))
    )
    return Pose(np.array(xyz, float), turn)


def without_rounding(numbers: Array) -> tuple[float, ...]:
    """Return the numbers with rounding errors of rotations removed."""
    return tuple(0.0 if abs(x) < _ROUNDING else float(x) for x in numbers)


def angles(orientation: Array) -> tuple[float, float, float]:
    """Return yaw, pitch and roll (rad) of a unit quaternion (4,)."""
    axes = rotation(orientation)
    level = math.hypot(axes[0, 0], axes[1, 0])
    pitch = math.atan2(-axes[2, 0], level)
    if level < 1e-9:  # gimbal lock: yaw and roll are the same rotation
        yaw, roll = math.atan2(-axes[0, 1], axes[1, 1]), 0.0
    else:
        yaw, roll = math.atan2(axes[1, 0], axes[0, 0]), math.atan2(axes[2, 1], axes[2, 2])
    yaw, pitch, roll = without_rounding(np.array((yaw, pitch, roll)))
    return yaw, pitch, roll
