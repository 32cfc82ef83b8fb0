"""Plain Python floats of arrays, whose text is exact: what the native scripts are made of."""

from __future__ import annotations

import numpy as np

from wmspec.sim.scene.model import Array, Pose


def floats(values: Array) -> tuple[float, ...]:
    """All numbers of an array, in order."""
    return tuple(np.asarray(values, float).ravel().tolist())


def rows(values: Array) -> tuple[tuple[float, ...], ...]:
    """The numbers of each row of an array."""
    return tuple(map(tuple, np.asarray(values, float).tolist()))


def numbers(pose: Pose) -> tuple[float, ...]:
    """Position and quaternion (w, x, y, z) of a pose."""
    return floats(np.concatenate([pose.position, pose.orientation]))


def placed(values: tuple[float, ...]) -> Pose:
    """The pose of `numbers`."""
    return Pose(np.array(values[:3]), np.array(values[3:]))
