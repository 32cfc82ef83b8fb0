"""Paths of kinematic bodies: pieces of constant velocity with jumps between them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from math import ceil

import numpy as np

from wmspec.sim.scene.model import Action, Array, Body, Follow, Glide, Pose, Scene, Teleport, Vanish
from wmspec.sim.scene.model.numbers import floats, rows
from wmspec.sim.scene.model.transform import conjugate, from_rotation_vector, multiply, to_rotation_vector
from wmspec.sim.scene.physics.episode import KinematicPath, Vector

Move = Glide | Follow | Teleport
_STEP_EPSILON = 1e-6  # steps
_REST = (0.0, 0.0, 0.0)
VANISHED_HEIGHT, VANISHED_SPACING = 1000.0, 10.0  # m: height and spacing of vanished bodies
MAX_START_GAP = 1e-3  # m and rad: largest gap between a body and the start of its path


@dataclass(frozen=True)
class PathPiece:
    """A piece from `time` (s) on: position and velocity (3,), orientation (4,), angular velocity (3,) rad/s."""

    time: float
    point: Vector
    turn: Vector
    velocity: Vector
    spin: Vector

    def at(self, time: float) -> Pose:
        """Return the pose at `time`."""
        point, turn, velocity, spin = map(np.array, (self.point, self.turn, self.velocity, self.spin))
        dt = time - self.time
        return Pose(point + dt * velocity, multiply(from_rotation_vector(dt * spin), turn))

    def since(self, time: float) -> PathPiece:
        """Return the same motion with a start no earlier than `time`."""
        if self.time >= time:
            return self
        pose = self.at(time)
        return PathPiece(time, floats(pose.position), floats(pose.orientation), self.velocity, self.spin)


def track(scene: Scene, index: int, steps_per_second: int) -> KinematicPath:
    """Return the path of kinematic body `index`. Jumps are at whole steps."""
    body = scene.bodies[index]
    parts = [_rest(0.0, body.pose)]
    for move in moves_of(scene.actions, body):
        for part in _parts(move, parts[-1].at(move.start), steps_per_second):
            parts.append(part.since(parts[-1].time))
    for vanish in (a for a in scene.actions if isinstance(a, Vanish) and a.body == body.name):
        left = _rest(
            first_step(vanish.start, steps_per_second) / steps_per_second,
            Pose(vanished_position(index), np.array(parts[0].turn)),
        )
        parts = [*(part for part in parts if part.time < left.time), left]
    return KinematicPath(
        index,
        tuple(float(part.time) for part in parts),
        tuple(part.point for part in parts),
        tuple(part.velocity for part in parts),
        tuple(part.turn for part in parts),
        tuple(part.spin for part in parts),
        floats(np.array(body.surface_velocity)),
    )


def first_step(time: float, steps_per_second: int) -> int:
    """Return the number of the first step that begins at `time` (s) or later."""
    return ceil(time * steps_per_second - _STEP_EPSILON)


def vanished_position(index: int) -> Array:
    """Return the position (3,) of body `index` after it vanished."""
    return np.array([VANISHED_SPACING * index, 0.0, VANISHED_HEIGHT])


def moves_of(actions: Sequence[Action], body: Body) -> list[Move]:
    """Return the actions that move a kinematic body, in order of time. After a teleport, a glide goes on from there."""
    moves = [a for a in actions if isinstance(a, Glide | Follow | Teleport) and a.body == body.name]
    jumps = sorted({move.start for move in moves if isinstance(move, Teleport)})
    parts = [part for move in moves for part in (_divided(move, jumps) if isinstance(move, Glide) else (move,))]
    return sorted(parts, key=lambda move: (move.start, end_time(move)))


def _divided(glide: Glide, times: Sequence[float]) -> Iterator[Glide]:
    """Yield the parts of a glide between the times (s) within it."""
    ends = [glide.start, *(time for time in times if glide.start < time < glide.stop), glide.stop]
    yield from (replace(glide, start=start, stop=stop) for start, stop in pairwise(ends))


def end_time(move: Move) -> float:
    """Return the end of a move, s."""
    return move.start if isinstance(move, Teleport) else move.stop


def overlaps(actions: Sequence[Action], bodies: Sequence[Body]) -> Iterator[tuple[Move, Move]]:
    """Yield pairs of moves of one body of which the second starts before the first ends."""
    for body in bodies:
        for first, second in pairwise(moves_of(actions, body)):
            if second.start < end_time(first) - 1e-9 or second.start == first.start == end_time(second) == end_time(
                first
            ):
                yield first, second


def misplaced_paths(scene: Scene) -> Iterator[tuple[Follow, Array]]:
    """Yield paths that do not start at their body, with the position (3,) of the body, m."""
    for body in scene.bodies:
        here = _rest(0.0, body.pose)
        for move in moves_of(scene.actions, body):
            pose = here.at(move.start)
            if isinstance(move, Follow) and _apart(move, pose):
                yield move, pose.position
            here = _last(move, pose)


def _apart(move: Follow, pose: Pose) -> bool:
    turn = (
        0.0
        if move.orientations is None
        else np.abs(to_rotation_vector(_between(pose.orientation, move.orientations[0]))).max()
    )
    return bool(np.linalg.norm(move.points[0] - pose.position) > MAX_START_GAP or turn > MAX_START_GAP)


def _parts(move: Move, here: Pose, steps_per_second: int) -> list[PathPiece]:
    """Return the pieces of a move that starts at pose `here`, and the rest after it."""
    match move:
        case Glide():
            going = PathPiece(move.start, floats(here.position), floats(here.orientation), floats(move.velocity), _REST)
            return [going, _rest(move.stop, going.at(move.stop))]
        case Teleport():
            return [_rest(first_step(move.start, steps_per_second) / steps_per_second, _placed(move, here))]
        case Follow():
            return _followed(move, here)


def _placed(move: Teleport, here: Pose) -> Pose:
    return Pose(move.position, here.orientation if move.orientation is None else move.orientation)


def _followed(move: Follow, here: Pose) -> list[PathPiece]:
    turns = _turns(move, here)
    lasting = np.diff(move.times)[:, None]
    velocities = np.diff(move.points, axis=0) / lasting
    spins = to_rotation_vector(_between(turns[:-1], turns[1:])) / lasting
    times = (move.start + move.times[:-1]).tolist()
    parts = zip(times, *map(rows, (move.points[:-1], turns[:-1], velocities, spins)), strict=True)
    return [*(PathPiece(*part) for part in parts), _last(move, here)]


def _last(move: Move, here: Pose) -> PathPiece:
    """Return the rest after a move that starts at pose `here`."""
    match move:
        case Teleport():
            return _rest(move.start, _placed(move, here))
        case Follow():
            return _rest(move.stop, Pose(move.points[-1], _turns(move, here)[-1]))
        case Glide():
            return _parts(move, here, 1)[-1]


def _turns(move: Follow, here: Pose) -> Array:
    return np.tile(here.orientation, (len(move.times), 1)) if move.orientations is None else move.orientations


def _between(a: Array, b: Array) -> Array:
    return multiply(b, conjugate(a))


def _rest(time: float, pose: Pose) -> PathPiece:
    return PathPiece(time, floats(pose.position), floats(pose.orientation), _REST, _REST)
