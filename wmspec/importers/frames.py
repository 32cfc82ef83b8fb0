"""Places as 4 × 4 matrices, and the turns and principal axes in them: yaw about z, pitch about y, roll about x."""

from __future__ import annotations

import math

import numpy as np

from wmspec.importers.model import Array

#: Less than this is rounding (m, rad).
_NOTHING = 1e-12


def place(xyz: tuple[float, ...] = (0.0, 0.0, 0.0), rpy: tuple[float, ...] = (0.0, 0.0, 0.0)) -> Array:
    """A frame at a point, turned by roll, pitch and yaw about the axes that stand still, in this order."""
    made = np.eye(4)
    made[:3, :3] = _about(2, rpy[2]) @ _about(1, rpy[1]) @ _about(0, rpy[0])
    made[:3, 3] = xyz
    return made


def inverse(frame: Array) -> Array:
    """The place of the outer frame in the inner one."""
    made = np.eye(4)
    made[:3, :3] = frame[:3, :3].T
    made[:3, 3] = -frame[:3, :3].T @ frame[:3, 3]
    return made


def point(frame: Array, local: Array) -> Array:
    """A point of the frame, in the one around it."""
    return np.asarray(frame[:3, :3] @ local + frame[:3, 3])


def clean(numbers: Array) -> tuple[float, ...]:
    """Numbers without the rounding that turns have left."""
    return tuple(0.0 if abs(x) < _NOTHING else float(x) for x in numbers)


def turn(axes: Array) -> tuple[float, float, float]:
    """Yaw, pitch and roll (rad) of a rotation (3, 3)."""
    level = math.hypot(axes[0, 0], axes[1, 0])
    pitch = math.atan2(-axes[2, 0], level)
    if level < 1e-9:  # it looks straight up or down, where yaw and roll are the same turn
        yaw, roll = math.atan2(-axes[0, 1], axes[1, 1]), 0.0
    else:
        yaw, roll = math.atan2(axes[1, 0], axes[0, 0]), math.atan2(axes[2, 1], axes[2, 2])
    yaw, pitch, roll = clean(np.array((yaw, pitch, roll)))
    return yaw, pitch, roll


def principal(tensor: Array) -> tuple[tuple[float, ...], tuple[float, float, float]]:
    """The principal moments (kg m²) of a tensor of inertia, and how their axes are turned."""
    if not np.any(tensor - np.diag(np.diag(tensor))):
        return tuple(float(m) for m in np.diag(tensor)), (0.0, 0.0, 0.0)
    moments, axes = np.linalg.eigh(tensor)
    if np.linalg.det(axes) < 0:
        axes[:, 0] *= -1
    return tuple(float(m) for m in moments), turn(axes)


def _about(axis: int, angle: float) -> Array:
    cos, sin = math.cos(angle), math.sin(angle)
    made = np.eye(3)
    i, j = (axis + 1) % 3, (axis + 2) % 3
    made[i, i], made[i, j], made[j, i], made[j, j] = cos, -sin, sin, cos
    return made
