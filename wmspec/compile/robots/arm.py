"""Arms: a chain of revolute joints with a two-finger hand, and its forward and inverse kinematics."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Arm:
    """A robot arm in SI units; frames are 4 x 4 matrices.

    `frames` (n, 4, 4) gives each joint in the previous link; joints turn about their z. `hand` is the hand's frame in
    the last joint. The tool is `reach` ahead along the hand's z, between the fingers, which are `finger` ahead and open
    along its y. `low`, `high` (rad) and `speed` (rad/s) are the joint limits. `home` is the preferred configuration.
    `rest` is the configuration before and between actions: the hand retracted, looking down.

    `hull` (2, 3) bounds the hand, `tip` the left finger in its own frame. `opening` is the maximum finger distance,
    `palm` the distance from the tool up to the hand's hull. The pads are `pad` thick along y and `width` wide along x.
    They press with `grip` (N) and the friction `rubber`. `asset` names the USD file with the prims: a resource of
    wmspec or a full path.
    """

    frames: Array
    hand: Array
    reach: float
    finger: float
    low: Array
    high: Array
    speed: Array
    home: Array
    rest: Array
    hull: Array
    tip: Array
    opening: float
    palm: float
    pad: float
    width: float
    grip: float
    rubber: float
    asset: str
    joints: tuple[str, ...]

    def links(self, q: Array, base: Array) -> list[Array]:
        """Return the frames of the base, of each link and of the hand for the joint angles `q` (n,)."""
        frames = [base]
        for frame, angle in zip(self.frames, q, strict=True):
            frames.append(frames[-1] @ frame @ axis_rotation(2, float(angle)))
        return [*frames, frames[-1] @ self.hand]

    def tool(self, q: Array, base: Array) -> Array:
        """Return the frame of the tool (4, 4)."""
        return self.links(q, base)[-1] @ translation(0.0, 0.0, self.reach)

    def jacobian(self, q: Array, base: Array) -> tuple[Array, Array]:
        """Return the Jacobian of the tool (6, n) and its frame (4, 4)."""
        joints = np.array(self.links(q, base)[1:-1])
        tip = joints[-1] @ self.hand @ translation(0.0, 0.0, self.reach)
        axes = joints[:, :3, 2]
        return np.concatenate([np.cross(axes, tip[:3, 3] - joints[:, :3, 3]), axes], axis=1).T, tip


#: Maximum length (m) of the pad at the end of a finger.
MAX_PAD_LENGTH = 0.019
#: Copied, since that takes a seventh of the time of `np.eye`, and planning needs many.
_IDENTITY = np.eye(4)


def axis_rotation(axis: int, angle: float) -> Array:
    """Return the rotation (4, 4) about coordinate axis `axis`."""
    c, s = np.cos(angle), np.sin(angle)
    turn = _IDENTITY.copy()
    i, j = ((1, 2), (2, 0), (0, 1))[axis]
    turn[i, i] = turn[j, j] = c
    turn[i, j], turn[j, i] = -s, s
    return turn


def translation(x: float, y: float, z: float) -> Array:
    """Return a translation (4, 4)."""
    way = _IDENTITY.copy()
    way[:3, 3] = x, y, z
    return way


def downward_pose(x: float, y: float, z: float, yaw: float = 0.0) -> Array:
    """Return the pose (4, 4) of a tool that points straight down, its fingers opening along `yaw` + 90 degrees."""
    return translation(x, y, z) @ axis_rotation(2, yaw) @ axis_rotation(0, np.pi)


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
