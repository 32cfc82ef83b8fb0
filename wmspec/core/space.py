"""Vectors, rotations and poses as plain tuples, so that checking a spec does not import numpy.

Quaternions are (w, x, y, z) of length 1. Lengths are metres, angles radians.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

Vector = tuple[float, float, float]
Quaternion = tuple[float, float, float, float]

ORIGIN: Vector = (0.0, 0.0, 0.0)
UP: Vector = (0.0, 0.0, 1.0)
IDENTITY_QUAT: Quaternion = (1.0, 0.0, 0.0, 0.0)


def add(a: Vector, b: Vector) -> Vector:
    """Return a + b."""
    return (a[0] + b[0], a[1] + b[1], a[2] + b[2])


def scale(factor: float, v: Vector) -> Vector:
    """Return factor * v."""
    return (factor * v[0], factor * v[1], factor * v[2])


def dot(a: Vector, b: Vector) -> float:
    """Return the inner product."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def cross(a: Vector, b: Vector) -> Vector:
    """Return the vector product."""
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def unit(v: Vector) -> Vector:
    """Return v at length 1."""
    return scale(1 / math.hypot(*v), v)


def multiply(a: Quaternion, b: Quaternion) -> Quaternion:
    """Return the rotation `b` followed by `a`."""
    if IDENTITY_QUAT in (a, b):
        return b if a == IDENTITY_QUAT else a
    (aw, ax, ay, az), (bw, bx, by, bz) = a, b
    return (
        aw * bw - ax * bx - ay * by - az * bz,
        aw * bx + ax * bw + ay * bz - az * by,
        aw * by - ax * bz + ay * bw + az * bx,
        aw * bz + ax * by - ay * bx + az * bw,
    )


def inverse(q: Quaternion) -> Quaternion:
    """Return the inverse rotation."""
    return (q[0], -q[1], -q[2], -q[3])


def rotate(q: Quaternion, v: Vector) -> Vector:
    """Return v rotated by q. A vector along the axis of q stays exactly equal."""
    if q == IDENTITY_QUAT:
        return v
    axis = (q[1], q[2], q[3])
    twice = scale(2.0, cross(axis, v))
    return add(add(v, scale(q[0], twice)), cross(axis, twice))


def from_ypr(yaw: float, pitch: float = 0.0, roll: float = 0.0) -> Quaternion:
    """Return the rotation about z, then about the new y axis, then about the new x axis."""
    about_z: Quaternion = (math.cos(yaw / 2), 0.0, 0.0, math.sin(yaw / 2))
    if pitch == 0 and roll == 0:
        return about_z
    about_y: Quaternion = (math.cos(pitch / 2), 0.0, math.sin(pitch / 2), 0.0)
    about_x: Quaternion = (math.cos(roll / 2), math.sin(roll / 2), 0.0, 0.0)
    return multiply(multiply(about_z, about_y), about_x)


def from_axis_angle(axis: Vector, angle: float) -> Quaternion:
    """Return the rotation about a unit vector."""
    sin = math.sin(angle / 2)
    return (math.cos(angle / 2), sin * axis[0], sin * axis[1], sin * axis[2])


def align_z(normal: Vector) -> Quaternion:
    """Return the shortest rotation from the z axis to a unit vector other than (0, 0, -1)."""
    if normal[2] >= 1:
        return IDENTITY_QUAT
    w, x, y = 1 + normal[2], -normal[1], normal[0]
    size = math.hypot(w, x, y)
    return (w / size, x / size, y / size, 0.0)


def align_x(x: Vector) -> Quaternion:
    """Return the shortest rotation from the x axis to a unit vector."""
    if x[0] <= -1 + 1e-12:
        return (0.0, 0.0, 0.0, 1.0)
    w, y, z = 1 + x[0], -x[2], x[1]
    size = math.hypot(w, y, z)
    return (w / size, 0.0, y / size, z / size)


def heading_vector(angle: float, climb: float = 0.0) -> Vector:
    """Return the unit vector with this azimuth (`angle`) and elevation (`climb`)."""
    level = math.cos(climb)
    return (level * math.cos(angle), level * math.sin(angle), math.sin(climb))


@dataclass(frozen=True)
class Pose:
    """A rigid transform from a local frame to its parent."""

    position: Vector = ORIGIN
    orientation: Quaternion = IDENTITY_QUAT

    def apply(self, point: Vector) -> Vector:
        """Return a local point in the parent frame."""
        return add(self.position, rotate(self.orientation, point))

    def inverse_apply(self, point: Vector) -> Vector:
        """Return a point of the parent frame in the local frame."""
        return rotate(inverse(self.orientation), add(point, scale(-1.0, self.position)))

    def compose(self, inner: Pose) -> Pose:
        """Return the parent-frame pose of a frame at `inner` in the local frame."""
        return Pose(self.apply(inner.position), multiply(self.orientation, inner.orientation))


IDENTITY = Pose()
