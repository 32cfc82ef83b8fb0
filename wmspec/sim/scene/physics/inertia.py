"""Mass properties of bodies made of solid, homogeneous shapes."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import permutations

import numpy as np

from wmspec.core.diagnostics import WmsError
from wmspec.sim.scene.model import Array, Inertia, Pose
from wmspec.sim.scene.model.transform import apply, multiply, quaternion, rotate, rotation
from wmspec.sim.shapes import Shape

_ROUND_OFF = 1e-9  # relative to the trace: smaller products of inertia are rounding errors


def inertia(parts: Sequence[tuple[Shape, Pose, float]]) -> Inertia:
    """Return the mass properties of rigidly joined `parts`: shape, its pose in the body's frame, its mass (kg).

    The principal axes are those nearest to the body's own (of a single part: to that part's own), so a body that is
    symmetric about its axes keeps them. Raises WmsError if there is no part or a mass is not positive.
    """
    if not parts or not all(0 < mass < np.inf for _, _, mass in parts):
        raise WmsError("a dynamic body needs at least one shape, each with a positive, finite mass (kg)")
    if len(parts) == 1:
        return _single(*parts[0])
    total = sum(mass for _, _, mass in parts)
    placed = [
        (apply(pose, np.array(shape.center)), pose, np.array(shape.tensor) * mass, mass) for shape, pose, mass in parts
    ]
    center = np.sum([mass * c for c, _, _, mass in placed], axis=0) / total
    tensor = np.zeros((3, 3))
    for c, pose, own, mass in placed:
        turn, arm = rotation(pose.orientation), c - center
        tensor += turn @ own @ turn.T + mass * (arm @ arm * np.eye(3) - np.outer(arm, arm))  # Huygens and Steiner
    axes, moments = principal(tensor)
    return Inertia(float(total), center, axes, moments)


def principal(tensor: Array) -> tuple[Array, Array]:
    """Return axes (4,) and moments (3,) of a symmetric tensor (3, 3), ordered and signed closest to the given axes."""
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
    axes, moments = principal(np.array(shape.tensor) * mass)
    center = pose.position + rotate(pose.orientation, np.array(shape.center))
    return Inertia(float(mass), center, multiply(pose.orientation, axes), moments)
