"""Unit quaternions (w, x, y, z), single ones: arrays (4,)."""

from __future__ import annotations

from collections.abc import Sequence
from math import atan2, sqrt

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def multiply(a: Sequence[float] | Array, b: Sequence[float] | Array) -> Array:
    """The rotation `b` followed by the rotation `a`, (4,)."""
    (aw, ax, ay, az), (bw, bx, by, bz) = map(float, a), map(float, b)
    return np.array(
        [
            aw * bw - ax * bx - ay * by - az * bz,
            aw * bx + ax * bw + ay * bz - az * by,
            aw * by - ax * bz + ay * bw + az * bx,
            aw * bz + ax * by - ay * bx + az * bw,
        ]
    )


def rotate(q: Sequence[float] | Array, v: Sequence[float] | Array) -> Array:
    """The vector or vectors `v` (..., 3) rotated by the quaternion or quaternions `q` (..., 4)."""
    q, v = np.asarray(q, float), np.asarray(v, float)
    w, u = q[..., :1], q[..., 1:]
    t = 2.0 * np.cross(u, v)
    rotated: Array = v + w * t + np.cross(u, t)
    return rotated


def rotation_vector(start: Sequence[float] | Array, end: Sequence[float] | Array) -> Array:
    """The rotation from one orientation to another: its axis (3,), as long as its angle (rad, 0 to pi)."""
    w, x, y, z = map(float, start)
    difference = multiply(end, (w, -x, -y, -z))
    if difference[0] < 0:
        difference = -difference
    sine = sqrt(difference[1] ** 2 + difference[2] ** 2 + difference[3] ** 2)
    vector: Array = difference[1:] * (2 * atan2(sine, difference[0]) / (sine or 1.0))
    return vector
