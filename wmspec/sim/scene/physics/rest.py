"""Steps that an engine may leave out, and kinematic bodies that it need not move, because nothing depends on them.

For engines whose bodies do not sleep. Native scripts contain a copy of these definitions.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from wmspec.sim.scene.model.transform import rotate
from wmspec.sim.scene.physics.rigid import Assembly, Rigid

REST_SPEED, REST_SPIN = 5e-5, 5e-4  # m/s and rad/s: resting bodies creep by up to 1.2e-5 m/s
JITTER_SPEED, JITTER_SPIN = 1e-3, 1e-2  # m/s and rad/s: tiles that lie on tiles tremble in place
REST_CHECKS, CHECK_STEPS = 24, 8  # a body rests after 24 checks in a row, one every 8 steps: 0.1 s
REACH = 0.01  # m: at larger distances no engine pushes
HORIZON = 1024  # steps that are examined at once while everything rests
WINDOW = 16  # steps for which distant kinematic bodies stay where they are
FASTEST_FALL = 0.1  # m/s: speed gained in a window


class Rest:
    """Whether the dynamic `bodies` rest, and which kinematic bodies are near them.

    `step` is the time step (s).
    """

    def __init__(self, bodies: Sequence[Rigid], step: float) -> None:
        self.dynamic = [i for i, body in enumerate(bodies) if body.motion == "dynamic"]
        self.boxes = np.array([bounding_box(body) for body in bodies])
        self.radii = np.linalg.norm(np.abs(self.boxes).max(axis=1), axis=1)
        self.window = WINDOW * step
        period = REST_CHECKS * CHECK_STEPS * step
        self.drift = np.array([REST_SPEED * period / 2] * 3 + [REST_SPIN * period / 4] * 4)  # m, and quaternions
        self.anchor: Any = None
        self.led: list[int] = []
        self.idle, self.checks, self.steps, self.until = False, 0, 0, 0
        self.clear: Any = None
        self.near: set[int] = set()

    def follow(self, paths: Mapping[int, tuple[Any, Any, Any]]) -> None:
        """Set the paths of the kinematic bodies (see `World.driven`)."""
        self.led = list(paths)
        if self.led:
            self.places = np.stack([here for here, _, _ in paths.values()], axis=1)
            self.speeds = np.stack([speeds for _, _, speeds in paths.values()], axis=1)
            self.rates = np.linalg.norm(self.speeds[..., :3], axis=2)

    def wake(self) -> None:
        """Leave out no step until everything rests again."""
        self.idle, self.checks, self.clear, self.until, self.anchor = False, 0, None, 0, None

    def leave_out(self, first: int, most: int, state: Callable[[int], Any]) -> int:
        """Return how many steps from `first` on change nothing, at most `most`. `state` returns the state of a body."""
        if not (self.idle and most):
            return 0
        if not self.led:
            return most
        if self.clear is None or first >= len(self.clear):
            self.clear = self.clearance(first, state)
        ahead = self.clear[first : first + most]
        if ahead.all():
            return len(ahead)
        if not ahead[0]:
            self.wake()
        return int(ahead.argmin())

    def check(self, state: Callable[[int], Any], held: bool) -> None:
        """Examine the bodies after a step: whether they tremble at most, and stay where they began to.

        They stay as near as a body with constant acceleration that reaches the speed of rest. Nothing rests while a
        body is `held`.
        """
        self.steps += 1
        if self.steps % CHECK_STEPS or not self.dynamic:
            return
        if held or any(map(is_moving, map(state, self.dynamic))):
            self.checks, self.anchor = 0, None
        else:
            poses = np.array([state(body)[:7] for body in self.dynamic])
            if self.anchor is None or (np.abs(poses - self.anchor) > self.drift).any():
                self.checks, self.anchor = 0, poses
            self.checks += 1
        self.idle = self.checks > REST_CHECKS

    def clearance(self, first: int, state: Callable[[int], Any]) -> Any:
        """Return for each step until `HORIZON` after `first` whether no moving kinematic body is near a dynamic one.

        Steps before `first` count as clear.
        """
        places, speeds = (whole[first : first + HORIZON] for whole in (self.places, self.speeds))
        moves = (places != places[:1]).any(axis=2) | speeds.any(axis=2)
        near = np.zeros(moves.shape, bool)
        for body in self.dynamic:
            pose = np.asarray(state(body))[:7]
            apart = np.linalg.norm(places[..., :3] - pose[:3], axis=2)
            for k, led in enumerate(self.led):
                close = np.flatnonzero(moves[:, k] & (apart[:, k] < self.radii[led] + self.radii[body] + REACH))
                near[close, k] |= box_distance(self.boxes[led], places[close, k], self.boxes[body], pose) < REACH
        return np.concatenate([np.ones(first, bool), ~(near & moves).any(axis=1)])

    def neighbours(self, i: int, state: Callable[[int], Any]) -> set[int] | None:
        """Return the kinematic bodies near dynamic ones in step `i`; None at the start of a window, when all move."""
        if i < self.until:
            return self.near
        self.until = i + WINDOW
        states = np.array([state(body) for body in self.dynamic])
        reach = (
            (np.linalg.norm(states[:, 7:10], axis=1) + FASTEST_FALL) * self.window + self.radii[self.dynamic] + REACH
        )
        ways = self.rates[i : i + WINDOW].max(axis=0) * self.window + self.radii[self.led]
        apart = np.linalg.norm(self.places[i, :, None, :3] - states[None, :, :3], axis=2)
        close = (apart < ways[:, None] + reach[None]).any(axis=1)
        self.near = {body for body, is_near in zip(self.led, close.tolist(), strict=True) if is_near}
        return None


class RestingWorld:
    """What the worlds of engines share whose bodies do not sleep: they leave out steps while everything rests."""

    def __init__(self, assembly: Assembly) -> None:
        self.bodies = assembly.bodies
        self.trees = {limb.body: tree for tree in assembly.trees for limb in tree}
        self.rest_detector = Rest(assembly.bodies, assembly.step)
        self.states: dict[int, Any] = {}
        self.met: set[tuple[int, int]] = set()
        self.places: dict[int, Any] = {}
        self.loop_closures: dict[int, list[Any]] = {}
        self.skipped: int | None = None

    def move(self, i: int) -> None:
        """Move all kinematic bodies in step i."""

    def keep(self, body: int) -> None:
        """Reset a held body to its place."""

    def read_state(self, body: int) -> Any:
        """Return position, quaternion, linear and angular velocity of a body from the engine."""

    def stir(self) -> None:
        """Leave out no step until everything rests again."""
        self.states.clear()
        self.rest_detector.wake()
        if self.skipped is not None:
            self.move(self.skipped)
            self.resume()

    def resume(self) -> None:
        """Reset held bodies, which were not reset while steps were left out."""
        self.skipped = None
        for body in self.places:
            self.keep(body)

    def leave_out(self, first: int, most: int) -> int:
        """Leave out steps from `first` on that change nothing, at most `most`; return their number."""
        if left_out := self.rest_detector.leave_out(first, most, self.state):
            self.skipped = first + left_out - 1
        return left_out

    def state(self, body: int) -> Any:
        """Return position, quaternion, linear and angular velocity of a body in world axes (13,)."""
        if body not in self.states:
            self.states[body] = self.read_state(body)
        return self.states[body]


def is_moving(state: Any) -> bool:
    """Whether a body with this state (13,) is faster than resting bodies tremble."""
    _, _, _, _, _, _, _, u, v, w, p, q, r = state
    if max(abs(u), abs(v), abs(w)) > JITTER_SPEED:
        return True
    return bool(max(abs(p), abs(q), abs(r)) > JITTER_SPIN)


def bounding_box(body: Rigid) -> Any:
    """Return the lowest and highest coordinates (2, 3), m, of the colliding shapes of a body in its frame."""
    boxes = [np.zeros((2, 3))]
    for piece in body.pieces:
        size = np.array(piece.size)
        if piece.kind == "hull":
            corners = size.reshape(-1, 3)
        elif piece.kind in ("cylinder", "capsule"):
            corners = box_corners(np.array([size[0], size[0], size[1] / 2 + size[0]]))
        else:
            corners = box_corners(np.broadcast_to(size, 3))
        there = np.array(piece.pose[:3]) + rotate(np.array(piece.pose[3:]), corners)
        boxes.append(np.stack([there.min(axis=0), there.max(axis=0)]))
    return np.stack([np.min(boxes, axis=(0, 1)), np.max(boxes, axis=(0, 1))])


def box_corners(half: Any) -> Any:
    """Return the corners (8, 3) of a box around the origin with these half extents."""
    return half * np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])


def box_distance(box: Any, poses: Any, other: Any, pose: Any) -> Any:
    """Return a lower bound (T,), m, of the distance of a box (2, 3) at poses (T, 7) and another at one pose (7,).

    It is the largest gap along the axes of both boxes, negative if none separates them.
    """
    (middle, half), (there, around) = ((b.mean(axis=0), (b[1] - b[0]) / 2) for b in (box, other))
    axes = rotate(pose[3:], np.eye(3))  # rows are the axes of the other box
    turns = rotate(poses[:, None, 3:], np.eye(3))
    off = poses[:, :3] + rotate(poses[:, 3:], middle) - pose[:3] - rotate(pose[3:], there)
    tilt = turns @ axes.T  # components of each axis of one box along those of the other
    along = np.abs(off @ axes.T) - around - half @ np.abs(tilt)
    across = np.abs((turns @ off[:, :, None])[:, :, 0]) - half - np.abs(tilt) @ around
    return np.maximum(along, across).max(axis=1, initial=-np.inf)
