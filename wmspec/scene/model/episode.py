"""A scene, which is everything that an engine is given, and the trace of what happened in it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from wmspec.diagnostics import Diagnostic
from wmspec.scene.model.actions import Action
from wmspec.scene.model.bodies import Body, Joint
from wmspec.scene.model.cameras import Camera, Light, Observation
from wmspec.scene.model.geometry import Array, Pose

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
        """The pose of every body at `time` (s), in a straight line between the samples before and after it.

        A sample stands for what is within a millionth of a second of it. What is 1/240 s from one sample to the next
        leaves the line by 0.02 mm where it falls freely.
        """
        i = self.sample(time)
        position, orientation = self.position[i], self.orientation[i]
        if abs(late := time - self.time[i]) > INSTANT and 0 <= (j := i + (1 if late > 0 else -1)) < len(self.time):
            share = late / (self.time[j] - self.time[i])
            position = position + share * (self.position[j] - position)
            same = np.sign((self.orientation[j] * orientation).sum(axis=1, keepdims=True))  # q and -q are one turn
            orientation = (1 - share) * orientation + share * same * self.orientation[j]
            orientation /= np.linalg.norm(orientation, axis=1, keepdims=True)
        return tuple(Pose(p, q) for p, q in zip(position, orientation, strict=True))
