"""Joint angles for places of the tool: damped least squares, pulled home where the arm is free to choose."""

from __future__ import annotations

import numpy as np

from wmspec.compile.robots.arm import Arm, Array

TOLERANCE = 1e-6  # m and rad together
MOST = 100  # steps
DAMPING, PULL, STRIDE = 0.02, 0.05, 0.3
SPARE = 0.005  # rad: between knots a spline swings beyond them, by .0012 at most in 60 plans of each task


def solve(arm: Arm, target: Array, base: Array, near: Array) -> Array | None:
    """The joint angles (n,) near `near` that bring the tool to `target` (4, 4), or None if none are found.

    S. R. Buss and J.-S. Kim, Selectively damped least squares for inverse kinematics, 2005, section 3: damped least
    squares; the damping vanishes with the error, so that the last steps are Newton's.
    """
    low, high = np.minimum(arm.low + SPARE, arm.rest), np.maximum(arm.high - SPARE, arm.rest)
    q = near.copy()
    for _ in range(MOST):
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
    """The axis times the angle (3,) of a rotation matrix (3, 3)."""
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
