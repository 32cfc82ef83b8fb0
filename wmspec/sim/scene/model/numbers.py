"""Arrays as plain Python floats with exact text, for native scripts."""

from __future__ import annotations

import numpy as np

from wmspec.sim.scene.model import Array, Pose


def floats(values: Array) -> tuple[float, ...]:
    """Return all numbers of an array in order."""
    return tuple(np.asarray(values, float).ravel().tolist())


def rows(values: Array) -> tuple[tuple[float, ...], ...]:
    """Return the numbers of each row."""
    return tuple(map(tuple, np.asarray(values, float).tolist()))


def pose_numbers(pose: Pose) -> tuple[float, ...]:
    """Return position and quaternion (w, x, y, z) of a pose."""
    return floats(np.concatenate([pose.position, pose.orientation]))


def pose_of(values: tuple[float, ...]) -> Pose:
    """Return the pose of `pose_numbers`."""
    return Pose(np.array(values[:3]), np.array(values[3:]))
