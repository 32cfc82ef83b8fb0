"""An episode in an engine's own steps, and the one loop that plays it in any engine.

Needs numpy only: the native scripts contain these definitions as they stand here. All numbers are plain floats, so
that the `repr` of an `Episode` is the Python text of it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from wmspec.scene.transform import multiply, rotate

Vector = tuple[float, ...]

TOUCH = 0.002  # m: a body that slides fast hops by up to 1.6 mm in MuJoCo


@dataclass(frozen=True)
class Kick:
    """Before step number `step` the centre of mass of `body` gets these velocities, m/s and rad/s."""

    step: int
    body: int
    linear: Vector
    angular: Vector


@dataclass(frozen=True)
class Track:
    """The path of a kinematic body: from `times[i]` (s) on it moves from `points[i]` with `velocities[i]`."""

    body: int
    times: Vector
    points: tuple[Vector, ...]
    velocities: tuple[Vector, ...]

    def at(self, time: float) -> Any:
        """Position and velocity, (2, 3), at `time`."""
        i = int(np.searchsorted(self.times, time, side="right")) - 1
        velocity = np.array(self.velocities[i])
        return np.stack([np.array(self.points[i]) + (time - self.times[i]) * velocity, velocity])


@dataclass(frozen=True)
class Episode:
    """Samples at `rate` (Hz), `substeps` engine steps between them; poses are position and quaternion (w, x, y, z).

    `start` is where each body's centre-of-mass frame is, `mounts` where the body's own frame is inside that one.
    """

    rate: int
    substeps: int
    samples: int
    gravity: Vector
    start: tuple[Vector, ...]
    mounts: tuple[Vector, ...]
    dynamic: tuple[int, ...]
    kicks: tuple[Kick, ...]
    tracks: tuple[Track, ...]

    @property
    def step(self) -> float:
        """The engine's time step, s."""
        return 1 / (self.rate * self.substeps)


@dataclass(frozen=True)
class Recording:
    """`states` (T, N, 13): pose of the body's frame, linear and angular velocity of its centre of mass, world axes.

    `touching`: for each engine step the pairs of bodies less than `TOUCH` apart.
    """

    states: Any
    touching: list[set[tuple[int, int]]]


class World(Protocol):
    """What an engine must be able to do, for bodies by their number and in their centre-of-mass frames."""

    def kick(self, body: int, linear: Any, angular: Any) -> None:
        """Set the velocities of a dynamic body."""

    def drive(self, body: int, position: Any, velocity: Any) -> None:
        """Make a kinematic body move from `position` with `velocity` during the next step."""

    def step(self) -> None:
        """Advance by one time step."""

    def state(self, body: int) -> Sequence[float]:
        """Position (3), quaternion (4), linear (3) and angular velocity (3) of a dynamic body."""

    def touching(self) -> set[tuple[int, int]]:
        """The pairs of bodies, lower number first, less than `TOUCH` apart in the last step."""


def play(world: World, episode: Episode) -> Recording:
    """Play the episode in a freshly built world."""
    h = episode.step
    half_fall = np.array(episode.gravity) * (h / 2)
    states = np.zeros((episode.samples, len(episode.start), 13))
    states[:, :, :7] = episode.start
    touching = []
    for i in range((episode.samples - 1) * episode.substeps + 1):
        time = i / (episode.rate * episode.substeps)
        kicks = [kick for kick in episode.kicks if kick.step == i]
        for kick in kicks:  # engines fall by g h² too much in the first step; half a step less of g makes flight exact
            world.kick(kick.body, np.array(kick.linear) - half_fall, np.array(kick.angular))
        if i % episode.substeps == 0:
            observe(world, episode, kicks, time, states[i // episode.substeps])
        if i == (episode.samples - 1) * episode.substeps:
            break
        for track in episode.tracks:
            here = track.at(time)[0]
            world.drive(track.body, here, (track.at(time + h)[0] - here) / h)
        world.step()
        touching.append(world.touching())
    return Recording(mounted(states, episode), touching)


def observe(world: World, episode: Episode, kicks: list[Kick], time: float, into: Any) -> None:
    """Write the state of every body that moves into `into` (N, 13)."""
    for body in episode.dynamic:
        into[body] = world.state(body)
    for kick in kicks:
        into[kick.body, 7:] = kick.linear + kick.angular
    for track in episode.tracks:
        into[track.body, :3], into[track.body, 7:10] = track.at(time)


def mounted(states: Any, episode: Episode) -> Any:
    """The states (T, N, 13) with poses of the bodies' own frames in place of those of their centres of mass."""
    mounts = np.array(episode.mounts)
    turns = states[..., 3:7] / np.linalg.norm(states[..., 3:7], axis=-1, keepdims=True)
    positions = states[..., :3] + rotate(turns, mounts[:, :3])
    return np.concatenate([positions, multiply(turns, mounts[:, 3:]), states[..., 7:]], axis=-1)
