"""A scene, which is everything that an engine is given, and the trace of what happened in it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from wmspec.core.diagnostics import Diagnostic
from wmspec.sim.scene.model.actions import Action
from wmspec.sim.scene.model.bodies import Body, Joint
from wmspec.sim.scene.model.cameras import Camera, Light, Observation
from wmspec.sim.scene.model.geometry import Array, Pose

INSTANT = 1e-6  # s


@dataclass(frozen=True)
class Scene:
    """An episode, complete: everything that an engine needs to execute and draw it.

    `bodies` keep the stage's order, which is part of the result: engines are only bit-identical for a fixed order.
    `filtered`: pairs of names of bodies, each in the order of `bodies`, sorted, that pass through each other.
    `notes`: what of the stage was taken for something else, as warnings.
    """

    name: str
    gravity: Array
    bodies: tuple[Body, ...]
    actions: tuple[Action, ...]
    cameras: tuple[Camera, ...]
    light: Light
    background: tuple[float, float, float]
    observations: tuple[Observation, ...]
    duration: float
    rate: int = 240
    joints: tuple[Joint, ...] = ()
    filtered: tuple[tuple[str, str], ...] = ()
    notes: tuple[Diagnostic, ...] = ()


@dataclass(frozen=True)
class Contact:
    """Two bodies (in scene order) touched from `start` to `stop` (s)."""

    first: str
    second: str
    start: float
    stop: float


@dataclass(frozen=True)
class Trace:
    """An executed episode: T samples of all N bodies (static ones included, in scene order), the first at time 0.

    `position` (T, N, 3) and `orientation` (T, N, 4) are of the body's frame; `linear_velocity` and
    `angular_velocity` (T, N, 3) of its centre of mass, in world axes.
    """

    engine: str
    bodies: tuple[str, ...]
    time: Array
    position: Array
    orientation: Array
    linear_velocity: Array
    angular_velocity: Array
    contacts: tuple[Contact, ...]

    def sample(self, time: float) -> int:
        """The index of the sample nearest to `time` (s)."""
        return int(np.abs(self.time - time).argmin())

    def poses(self, time: float) -> tuple[Pose, ...]:
        """The pose of every body at `time` (s): on a straight line between the samples before and after it.

        A sample stands for what is within a microsecond of it, and for what leaps: a body that comes further than it is
        fast has been put elsewhere, and is on no way between. Where a body falls freely the line is off by 0.02 mm.
        """
        i = self.sample(time)
        position, orientation = self.position[i], self.orientation[i]
        j = i + (1 if time > self.time[i] else -1)
        if abs(time - self.time[i]) > INSTANT and 0 <= j < len(self.time):
            part = (time - self.time[i]) / (self.time[j] - self.time[i])
            share = np.where(self._leaps(i, j), 0.0, part)[:, None]
            other = self.orientation[j]
            alike = (orientation * other).sum(axis=1, keepdims=True) >= 0  # else -q, which is the same turn, is nearer
            position = position + share * (self.position[j] - position)
            orientation = orientation + share * (np.where(alike, other, -other) - orientation)
            orientation /= np.linalg.norm(orientation, axis=1, keepdims=True)
        return tuple(Pose(p, q) for p, q in zip(position, orientation, strict=True))

    def _leaps(self, i: int, j: int) -> NDArray[np.bool_]:
        """Which bodies (N,) come twice as far from one sample to the next as their speeds at both could take them.

        The frame of a body is taken to be a metre from its centre of mass at most.
        """
        both = [i, j]
        speed = np.linalg.norm(self.linear_velocity[both], axis=2) + np.linalg.norm(self.angular_velocity[both], axis=2)
        reach = 2 * abs(self.time[j] - self.time[i]) * speed.max(axis=0) + 1e-3
        leaps: NDArray[np.bool_] = np.linalg.norm(self.position[j] - self.position[i], axis=1) > reach
        return leaps
