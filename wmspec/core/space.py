"""Points, turns and poses as plain tuples: a stage has few of them, and checking a spec should not wait for numpy.

Quaternions are (w, x, y, z) and of length 1; lengths are metres, angles radians.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

Vector = tuple[float, float, float]
Quaternion = tuple[float, float, float, float]

ORIGIN: Vector = (0.0, 0.0, 0.0)
UP: Vector = (0.0, 0.0, 1.0)
LEVEL: Quaternion = (1.0, 0.0, 0.0, 0.0)


def add(a: Vector, b: Vector) -> Vector:
    """The sum of two vectors."""
    return (a[0] + b[0], a[1] + b[1], a[2] + b[2])


def times(factor: float, v: Vector) -> Vector:
    """The vector, so many times as long."""
    return (factor * v[0], factor * v[1], factor * v[2])


def dot(a: Vector, b: Vector) -> float:
    """The inner product."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def cross(a: Vector, b: Vector) -> Vector:
    """The vector product."""
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def unit(v: Vector) -> Vector:
    """The vector at length 1."""
    return times(1 / math.hypot(*v), v)


def multiply(a: Quaternion, b: Quaternion) -> Quaternion:
    """First the turn `b`, then `a`."""
    if LEVEL in (a, b):
        return b if a == LEVEL else a
    (aw, ax, ay, az), (bw, bx, by, bz) = a, b
    return (
        aw * bw - ax * bx - ay * by - az * bz,
        aw * bx + ax * bw + ay * bz - az * by,
        aw * by - ax * bz + ay * bw + az * bx,
        aw * bz + ax * by - ay * bx + az * bw,
    )


def inverse(q: Quaternion) -> Quaternion:
    """The turn back."""
    return (q[0], -q[1], -q[2], -q[3])


def rotate(q: Quaternion, v: Vector) -> Vector:
    """The vector, turned. What lies along the axis of the turn stays exactly what it is."""
    if q == LEVEL:
        return v
    axis = (q[1], q[2], q[3])
    twice = times(2.0, cross(axis, v))
    return add(add(v, times(q[0], twice)), cross(axis, twice))


def turn(yaw: float, pitch: float = 0.0, roll: float = 0.0) -> Quaternion:
    """Turned about z, then about its own y axis, then about its own x axis."""
    about_z: Quaternion = (math.cos(yaw / 2), 0.0, 0.0, math.sin(yaw / 2))
    if pitch == 0 and roll == 0:
        return about_z
    about_y: Quaternion = (math.cos(pitch / 2), 0.0, math.sin(pitch / 2), 0.0)
    about_x: Quaternion = (math.cos(roll / 2), math.sin(roll / 2), 0.0, 0.0)
    return multiply(multiply(about_z, about_y), about_x)


def about(axis: Vector, angle: float) -> Quaternion:
    """Turned about a unit vector."""
    sin = math.sin(angle / 2)
    return (math.cos(angle / 2), sin * axis[0], sin * axis[1], sin * axis[2])


def tilt(normal: Vector) -> Quaternion:
    """The shortest turn that brings z to a unit vector; it must not point straight down."""
    if normal[2] >= 1:
        return LEVEL
    w, x, y = 1 + normal[2], -normal[1], normal[0]
    size = math.hypot(w, x, y)
    return (w / size, x / size, y / size, 0.0)


def facing(x: Vector) -> Quaternion:
    """The shortest turn that brings the x axis to a unit vector."""
    if x[0] <= -1 + 1e-12:
        return (0.0, 0.0, 0.0, 1.0)
    w, y, z = 1 + x[0], -x[2], x[1]
    size = math.hypot(w, y, z)
    return (w / size, 0.0, y / size, z / size)


def heading(angle: float, climb: float = 0.0) -> Vector:
    """The unit vector along a heading on the ground, so steeply upwards."""
    level = math.cos(climb)
    return (level * math.cos(angle), level * math.sin(angle), math.sin(climb))


@dataclass(frozen=True)
class Pose:
    """A rigid placement."""

    position: Vector = ORIGIN
    orientation: Quaternion = LEVEL

    def apply(self, point: Vector) -> Vector:
        """Where a point of the placed thing is."""
        return add(self.position, rotate(self.orientation, point))

    def seen(self, point: Vector) -> Vector:
        """A point of the world as seen from the placed thing."""
        return rotate(inverse(self.orientation), add(point, times(-1.0, self.position)))

    def then(self, inner: Pose) -> Pose:
        """The pose of what is placed at `inner` in the placed thing."""
        return Pose(self.apply(inner.position), multiply(self.orientation, inner.orientation))


HERE = Pose()
"""Where the thing itself is."""
