"""Arms: a chain of revolute joints with a hand of two fingers, and where its links are for given joint angles."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Arm:
    """A robot arm, SI units, frames as 4 x 4 matrices.

    `frames` (n, 4, 4): each joint's in the link before it, turning about its z. `hand` is the hand's frame in the last
    joint's; the tool is `reach` ahead along its z, between the fingers, which open along its y, `finger` ahead.
    `low`, `high` (rad) and `speed` (rad/s) are the joints' limits; `home` is where they are pulled to, and `rest` where
    they are before and between what it does: the hand drawn back, looking down. The hand is between the corners of
    `hull` (2, 3), the left finger between those of `tip` in its own frame. The hand opens `opening` wide; its own hull
    begins `palm` above the tool, and pads, `pad` thick (from the tool outward, along y) and `width` wide (along x),
    press with `grip` (N), with friction `rubber`. The prims are those of the file `asset`, of wmspec or by its
    whole path.
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
        """The frames of the base, of each link and of the hand, for the joint angles `q` (n,)."""
        frames = [base]
        for frame, angle in zip(self.frames, q, strict=True):
            frames.append(frames[-1] @ frame @ about(2, float(angle)))
        return [*frames, frames[-1] @ self.hand]

    def tool(self, q: Array, base: Array) -> Array:
        """Where the tool is (4, 4)."""
        return self.links(q, base)[-1] @ shift(0.0, 0.0, self.reach)

    def jacobian(self, q: Array, base: Array) -> tuple[Array, Array]:
        """How the tool moves and turns with the joints (6, n), and where it is (4, 4)."""
        joints = np.array(self.links(q, base)[1:-1])
        tip = joints[-1] @ self.hand @ shift(0.0, 0.0, self.reach)
        axes = joints[:, :3, 2]
        return np.concatenate([np.cross(axes, tip[:3, 3] - joints[:, :3, 3]), axes], axis=1).T, tip


def about(axis: int, angle: float) -> Array:
    """A turn (4, 4) about the axis number `axis`."""
    c, s = np.cos(angle), np.sin(angle)
    turn = np.eye(4)
    i, j = ((1, 2), (2, 0), (0, 1))[axis]
    turn[i, i] = turn[j, j] = c
    turn[i, j], turn[j, i] = -s, s
    return turn


def shift(x: float, y: float, z: float) -> Array:
    """A way (4, 4)."""
    way = np.eye(4)
    way[:3, 3] = x, y, z
    return way


def down(x: float, y: float, z: float, yaw: float = 0.0) -> Array:
    """A tool (4, 4) that looks straight down at a point, its fingers opening along `yaw` + 90 degrees."""
    return shift(x, y, z) @ about(2, yaw) @ about(0, np.pi)
