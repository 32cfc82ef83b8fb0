"""Mass properties of solid, homogeneous shapes, and of bodies made of several of them.

Formulas: Meriam and Kraige, Engineering Mechanics: Dynamics, table D/4. A mesh counts as its convex hull.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import permutations
from math import pi

import numpy as np

from wmspec.diagnostics import WmsError
from wmspec.scene.hull import solid
from wmspec.scene.model import Array, Box, Capsule, Cone, Cylinder, Inertia, Mesh, Pose, Shape, Sphere
from wmspec.scene.transform import apply, multiply, quaternion, rotate, rotation

_ROUND_OFF = 1e-9  # of the trace: products of inertia below this are rounding, not shape


def volume(shape: Shape) -> float:
    """The volume of a shape, m³."""
    match shape:
        case Box(half):
            return 8.0 * float(np.prod(half))
        case Sphere(r):
            return 4 / 3 * pi * r**3
        case Cylinder(r, h):
            return pi * r**2 * h
        case Cone(r, h):
            return pi * r**2 * h / 3
        case Capsule(r, h):
            return pi * r**2 * h + 4 / 3 * pi * r**3
        case Mesh():
            return float(solid(shape).volume)


def inertia(parts: Sequence[tuple[Shape, Pose, float]]) -> Inertia:
    """The mass properties of rigidly joined `parts`: shape, its pose in the body's frame, its mass (kg).

    The principal axes are those nearest to the body's own (of a single part: to that part's own), so a body that is
    symmetric about its axes keeps them. Raises WmsError if there is no part or a mass is not positive.
    """
    if not parts or not all(0 < mass < np.inf for _, _, mass in parts):
        raise WmsError("a dynamic body needs at least one shape, each with a positive, finite mass (kg)")
    if len(parts) == 1:
        return _single(*parts[0])
    total = sum(mass for _, _, mass in parts)
    placed = [(apply(pose, _center(shape)), pose, _tensor(shape) * mass, mass) for shape, pose, mass in parts]
    center = np.sum([mass * c for c, _, _, mass in placed], axis=0) / total
    tensor = np.zeros((3, 3))
    for c, pose, own, mass in placed:
        turn, arm = rotation(pose.orientation), c - center
        tensor += turn @ own @ turn.T + mass * (arm @ arm * np.eye(3) - np.outer(arm, arm))  # Huygens and Steiner
    axes, moments = principal(tensor)
    return Inertia(float(total), center, axes, moments)


def principal(tensor: Array) -> tuple[Array, Array]:
    """Axes (4,) and moments (3,) of a symmetric tensor (3, 3), in the order and signs nearest to the given axes."""
    off = tensor - np.diag(np.diag(tensor))
    if np.abs(off).max() <= _ROUND_OFF * np.trace(tensor):
        return np.array([1.0, 0.0, 0.0, 0.0]), np.diag(tensor).copy()
    moments, vectors = np.linalg.eigh((tensor + tensor.T) / 2)
    order = max(permutations(range(3)), key=lambda o: float(np.abs(np.diag(vectors[:, o])).sum()))
    vectors, moments = vectors[:, order], moments[list(order)]
    vectors = vectors * np.where(np.diag(vectors) < 0, -1.0, 1.0)
    if np.linalg.det(vectors) < 0:
        vectors[:, np.abs(np.diag(vectors)).argmin()] *= -1.0
    return quaternion(vectors), moments


def _single(shape: Shape, pose: Pose, mass: float) -> Inertia:
    axes, moments = principal(_tensor(shape) * mass)
    center = pose.position + rotate(pose.orientation, _center(shape))
    return Inertia(float(mass), center, multiply(pose.orientation, axes), moments)


def _center(shape: Shape) -> Array:
    """The centre of mass (3,) in the shape's frame."""
    match shape:
        case Cone(_, h):
            return np.array([0.0, 0.0, -h / 4])
        case Mesh():
            return np.asarray(solid(shape).center_mass, float)
        case _:
            return np.zeros(3)


def _tensor(shape: Shape) -> Array:
    """The tensor of inertia (3, 3) of 1 kg, about the centre of mass, m²."""
    match shape:
        case Box(half):
            x, y, z = np.square(half) / 3
            return np.diag([y + z, x + z, x + y])
        case Sphere(r):
            return np.diag([0.4 * r**2] * 3)
        case Cylinder(r, h):
            across = r**2 / 4 + h**2 / 12
            return np.diag([across, across, r**2 / 2])
        case Cone(r, h):
            across = 3 / 20 * r**2 + 3 / 80 * h**2
            return np.diag([across, across, 3 / 10 * r**2])
        case Capsule(r, h):
            return _capsule(r, h)
        case Mesh():
            hull = solid(shape)
            return np.asarray(hull.moment_inertia, float) / float(hull.mass)


def _capsule(r: float, h: float) -> Array:
    straight = pi * r**2 * h
    ends = 4 / 3 * pi * r**3
    m, n = straight / (straight + ends), ends / (straight + ends)
    across = m * (h**2 / 12 + r**2 / 4) + n * (0.4 * r**2 + h**2 / 4 + 3 * h * r / 8)
    return np.diag([across, across, m * r**2 / 2 + n * 0.4 * r**2])
