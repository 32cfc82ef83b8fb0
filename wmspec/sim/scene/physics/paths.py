"""Where a kinematic body is, as its actions say one after the other: parts of constant velocity, with jumps between."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from math import ceil

import numpy as np

from wmspec.sim.scene.model import Action, Array, Body, Follow, Glide, Pose, Scene, Teleport, Vanish
from wmspec.sim.scene.model.numbers import floats, rows
from wmspec.sim.scene.model.transform import conjugate, multiply, turned, turning
from wmspec.sim.scene.physics.episode import Track, Vector

Move = Glide | Follow | Teleport
_FUZZ = 1e-6  # steps
_REST = (0.0, 0.0, 0.0)
FAR, APART = 1000.0, 10.0  # m: how high what has vanished is, and how far from what else has
NEAR = 1e-3  # m and rad: how far from where the body is its way may begin


@dataclass(frozen=True)
class Part:
    """From `time` (s) on: position and velocity (3,), orientation (4,) and spin (3,) rad/s."""

    time: float
    point: Vector
    turn: Vector
    velocity: Vector
    spin: Vector

    def at(self, time: float) -> Pose:
        """Where it leads to at `time`."""
        point, turn, velocity, spin = map(np.array, (self.point, self.turn, self.velocity, self.spin))
        dt = time - self.time
        return Pose(point + dt * velocity, multiply(turning(dt * spin), turn))

    def since(self, time: float) -> Part:
        """The same motion, begun no earlier than `time`."""
        if self.time >= time:
            return self
        pose = self.at(time)
        return Part(time, floats(pose.position), floats(pose.orientation), self.velocity, self.spin)


def track(scene: Scene, index: int, steps_per_second: int) -> Track:
    """The path of the kinematic body number `index`; it jumps at whole steps only."""
    body = scene.bodies[index]
    parts = [_rest(0.0, body.pose)]
    for move in moves_of(scene.actions, body):
        for part in _parts(move, parts[-1].at(move.start), steps_per_second):
            parts.append(part.since(parts[-1].time))
    for gone in (a for a in scene.actions if isinstance(a, Vanish) and a.body == body.name):
        left = _rest(
            ceil(gone.start * steps_per_second - _FUZZ) / steps_per_second, Pose(away(index), np.array(parts[0].turn))
        )
        parts = [*(part for part in parts if part.time < left.time), left]
    return Track(
        index,
        tuple(float(part.time) for part in parts),
        tuple(part.point for part in parts),
        tuple(part.velocity for part in parts),
        tuple(part.turn for part in parts),
        tuple(part.spin for part in parts),
    )


def away(index: int) -> Array:
    """Where the body number `index` is (3,) when it has vanished."""
    return np.array([APART * index, 0.0, FAR])


def moves_of(actions: Sequence[Action], body: Body) -> list[Move]:
    """What moves the kinematic body, in order of time."""
    moves = [a for a in actions if isinstance(a, Glide | Follow | Teleport) and a.body == body.name]
    return sorted(moves, key=lambda move: (move.start, ended(move)))


def ended(move: Move) -> float:
    """When it is over, s."""
    return move.start if isinstance(move, Teleport) else move.stop


def overlaps(actions: Sequence[Action], bodies: Sequence[Body]) -> Iterator[tuple[Move, Move]]:
    """The pairs of which the second starts while the first still moves the same body."""
    for body in bodies:
        for first, second in pairwise(moves_of(actions, body)):
            if second.start < ended(first) - 1e-9 or second.start == first.start == ended(second) == ended(first):
                yield first, second


def astray(scene: Scene) -> Iterator[tuple[Follow, Array]]:
    """The ways that do not begin where their body is then, and where it is (3,) m."""
    for body in scene.bodies:
        here = _rest(0.0, body.pose)
        for move in moves_of(scene.actions, body):
            pose = here.at(move.start)
            if isinstance(move, Follow) and _apart(move, pose):
                yield move, pose.position
            here = _last(move, pose)


def _apart(move: Follow, pose: Pose) -> bool:
    turn = 0.0 if move.orientations is None else np.abs(turned(_between(pose.orientation, move.orientations[0]))).max()
    return bool(np.linalg.norm(move.points[0] - pose.position) > NEAR or turn > NEAR)


def _parts(move: Move, here: Pose, steps_per_second: int) -> list[Part]:
    """The parts of one action of a body that is `here` when it starts, and the rest that follows."""
    match move:
        case Glide():
            going = Part(move.start, floats(here.position), floats(here.orientation), floats(move.velocity), _REST)
            return [going, _rest(move.stop, going.at(move.stop))]
        case Teleport():
            return [_rest(ceil(move.start * steps_per_second - _FUZZ) / steps_per_second, move.pose)]
        case Follow():
            return _followed(move, here)


def _followed(move: Follow, here: Pose) -> list[Part]:
    turns = _turns(move, here)
    lasting = np.diff(move.times)[:, None]
    velocities = np.diff(move.points, axis=0) / lasting
    spins = turned(_between(turns[:-1], turns[1:])) / lasting
    times = (move.start + move.times[:-1]).tolist()
    parts = zip(times, *map(rows, (move.points[:-1], turns[:-1], velocities, spins)), strict=True)
    return [*(Part(*part) for part in parts), _last(move, here)]


def _last(move: Move, here: Pose) -> Part:
    """The rest after an action of a body that is `here` when it starts."""
    match move:
        case Teleport():
            return _rest(move.start, move.pose)
        case Follow():
            return _rest(move.stop, Pose(move.points[-1], _turns(move, here)[-1]))
        case Glide():
            return _parts(move, here, 1)[-1]


def _turns(move: Follow, here: Pose) -> Array:
    return np.tile(here.orientation, (len(move.times), 1)) if move.orientations is None else move.orientations


def _between(a: Array, b: Array) -> Array:
    return multiply(b, conjugate(a))


def _rest(time: float, pose: Pose) -> Part:
    return Part(time, floats(pose.position), floats(pose.orientation), _REST, _REST)
