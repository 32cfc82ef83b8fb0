"""Quaternions (w, x, y, z) and poses. Quaternion and vector arguments broadcast over leading axes."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from wmspec.sim.scene.model import Array, Pose

_AXES = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


def multiply(a: Array, b: Array) -> Array:
    """Return the rotations `b` followed by `a`: (..., 4) times (..., 4)."""
    a, b = np.asarray(a, float), np.asarray(b, float)
    single = a.ndim == b.ndim == 1  # plain floats are much faster here and bit-identical
    aw, ax, ay, az = a.tolist() if single else np.moveaxis(a, -1, 0)
    bw, bx, by, bz = b.tolist() if single else np.moveaxis(b, -1, 0)
    parts = [
        aw * bw - ax * bx - ay * by - az * bz,
        aw * bx + ax * bw + ay * bz - az * by,
        aw * by - ax * bz + ay * bw + az * bx,
        aw * bz + ax * by - ay * bx + az * bw,
    ]
    return np.array(parts) if single else np.stack(parts, axis=-1)


def conjugate(q: Array) -> Array:
    """Return the inverse of unit quaternions (..., 4)."""
    signs: Array = np.array([1.0, -1.0, -1.0, -1.0])
    return signs * q


def rotate(q: Array, v: Array) -> Array:
    """Return vectors `v` (..., 3) rotated by unit quaternions `q` (..., 4)."""
    q, v = np.asarray(q, float), np.asarray(v, float)
    if q.ndim == v.ndim == 1:  # as in `multiply`
        return np.array(rotate_one(q.tolist(), v.tolist()))
    w, u = q[..., :1], q[..., 1:]
    t = 2.0 * cross(u, v)
    return v + w * t + cross(u, t)


def rotate_one(q: Sequence[float], v: Sequence[float]) -> tuple[float, float, float]:
    """Return one vector rotated by one quaternion, in plain numbers."""
    (s, i, j, k), (x, y, z) = q, v
    a, b, c = 2.0 * (j * z - k * y), 2.0 * (k * x - i * z), 2.0 * (i * y - j * x)
    return x + s * a + (j * c - k * b), y + s * b + (k * a - i * c), z + s * c + (i * b - j * a)


def cross(a: Array, b: Array) -> Array:
    """Return the cross products of (..., 3) arrays: equal to numpy's to the bit, faster for few vectors."""
    after, before = (1, 2, 0), (2, 0, 1)
    return a.take(after, -1) * b.take(before, -1) - a.take(before, -1) * b.take(after, -1)


def from_rotation_vector(v: Array) -> Array:
    """Return unit quaternions (..., 4) of rotation vectors (..., 3), rad."""
    half = np.linalg.norm(v, axis=-1, keepdims=True) / 2
    turn: Array = np.concatenate([np.cos(half), np.sinc(half / np.pi) / 2 * v], axis=-1)
    return turn


def to_rotation_vector(q: Array) -> Array:
    """Return rotation vectors (..., 3) of unit quaternions (..., 4), at most pi long."""
    q = np.asarray(q, float)
    q = np.where(q[..., :1] < 0, -q, q)
    sine = np.linalg.norm(q[..., 1:], axis=-1, keepdims=True)
    vector: Array = q[..., 1:] * (2 * np.arctan2(sine, q[..., :1]) / np.where(sine > 0, sine, 1.0))
    return vector


def rotation(q: Array) -> Array:
    """Return rotation matrices (..., 3, 3), for column vectors, of unit quaternions (..., 4)."""
    q = np.asarray(q, float)
    if q.ndim == 1:  # as in `multiply`
        numbers = q.tolist()
        return np.array([rotate_one(numbers, axis) for axis in _AXES]).T
    return np.swapaxes(rotate(q[..., None, :], np.eye(3)), -1, -2)


def quaternion(m: Array) -> Array:
    """Return the unit quaternion (4,), w >= 0, of a matrix (3, 3) (Shepperd, J. Guidance and Control 1, 1978)."""
    m = np.asarray(m, float)
    x, y, z = np.diag(m)
    squares = np.array([1 + x + y + z, 1 + x - y - z, 1 - x + y - z, 1 - x - y + z])
    a, b, c = m[2, 1] - m[1, 2], m[0, 2] - m[2, 0], m[1, 0] - m[0, 1]
    d, e, f = m[0, 1] + m[1, 0], m[0, 2] + m[2, 0], m[1, 2] + m[2, 1]
    products = np.array([[0, a, b, c], [a, 0, d, e], [b, d, 0, f], [c, e, f, 0]])
    largest = int(squares.argmax())
    q: Array = products[largest]
    q[largest] = squares[largest]
    unit: Array = q / np.copysign(np.linalg.norm(q), q[0])
    return unit


def identity() -> Pose:
    """Return the identity pose."""
    return Pose(np.zeros(3), np.array([1.0, 0.0, 0.0, 0.0]))


def compose(outer: Pose, inner: Pose) -> Pose:
    """Return the pose of a frame at `inner` within a frame at `outer`."""
    return Pose(
        outer.position + rotate(outer.orientation, inner.position),
        multiply(outer.orientation, inner.orientation),
    )


def inverse(pose: Pose) -> Pose:
    """Return the inverse pose."""
    back = conjugate(pose.orientation)
    return Pose(-rotate(back, pose.position), back)


def apply(pose: Pose, points: Array) -> Array:
    """Return points (..., 3) of the frame `pose` in its parent frame."""
    return pose.position + rotate(pose.orientation, points)
