"""Inverse kinematics: damped least squares with a preference for the home configuration."""

from __future__ import annotations

import numpy as np

from wmspec.compile.robots.arm import Arm, Array

TOLERANCE = 1e-6  # norm of the error in m and rad
MAX_STEPS = 100  # of the solver
DAMPING, PULL, STRIDE = 0.02, 0.05, 0.3
LIMIT_MARGIN = 0.005  # rad: covers the overshoot of splines between knots


def solve(arm: Arm, target: Array, base: Array, near: Array) -> Array | None:
    """Return joint angles (n,) near `near` that bring the tool to `target` (4, 4), or None.

    S. R. Buss and J.-S. Kim, Selectively damped least squares for inverse kinematics, 2005, section 3: damped least
    squares. The damping vanishes with the error, so that the last steps are Newton steps.
    """
    low, high = np.minimum(arm.low + LIMIT_MARGIN, arm.rest), np.maximum(arm.high - LIMIT_MARGIN, arm.rest)
    q = near.copy()
    for _ in range(MAX_STEPS):
        jacobian, tip = arm.jacobian(q, base)
        error = np.concatenate([target[:3, 3] - tip[:3, 3], rotation_vector(target[:3, :3] @ tip[:3, :3].T)])
        size = float(np.linalg.norm(error))
        if size < TOLERANCE:
            return q
        inverse = jacobian.T @ np.linalg.inv(jacobian @ jacobian.T + (DAMPING * min(1.0, 5 * size)) ** 2 * np.eye(6))
        home = PULL * min(1.0, 20 * size) * (arm.home - q)
        step = inverse @ error + home - inverse @ (jacobian @ home)
        step *= min(1.0, STRIDE / max(float(np.abs(step).max()), STRIDE))
        q = np.clip(q + step, low, high)
    return None


def rotation_vector(turn: Array) -> Array:
    """Return the rotation vector (3,), axis times angle, of a rotation matrix (3, 3)."""
    cosine = np.clip((np.trace(turn) - 1) / 2, -1.0, 1.0)
    angle = float(np.arccos(cosine))
    skew = np.array([turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]])
    if angle < 1e-9:
        return np.asarray(skew / 2)
    if angle < np.pi - 1e-4:
        return np.asarray(skew * angle / (2 * np.sin(angle)))
    axis = np.sqrt(np.maximum((np.diag(turn) - cosine) / (1 - cosine), 0.0))
    largest = int(axis.argmax())
    signs = np.sign(turn[largest] + turn[:, largest])
    signs[largest] = 1.0
    return np.asarray(angle * axis * signs)
