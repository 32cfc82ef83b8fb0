"""Scenes, the complete input of engines, and traces, their output."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, Protocol

import numpy as np
from numpy.typing import NDArray

from wmspec.core.diagnostics import Diagnostic
from wmspec.sim.scene.model.actions import Action
from wmspec.sim.scene.model.bodies import Body, Joint
from wmspec.sim.scene.model.cameras import Camera, Frame, Light, Observation, Shot
from wmspec.sim.scene.model.geometry import Array, Pose

Look = Literal["parity", "photo"]
"""`parity` is equal in all engines; `photo` is path-traced by Mitsuba."""

TIME_EPSILON = 1e-6  # s


@dataclass(frozen=True)
class Scene:
    """An episode, complete: everything that an engine needs to execute and draw it.

    `bodies` keep the order of the stage, which affects the result: engines are bit-identical only for a fixed order.
    `filtered`: sorted pairs of names of bodies that do not collide, each in the order of `bodies`. `notes`: warnings
    about substitutions made by the reader.
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
    """A contact of two bodies (in scene order) from `start` to `stop` (s)."""

    first: str
    second: str
    start: float
    stop: float


@dataclass(frozen=True)
class Trace:
    """An executed episode: T samples of all N bodies (including static ones, in scene order), the first at time 0.

    `position` (T, N, 3) and `orientation` (T, N, 4) are of the body frame; `linear_velocity` and `angular_velocity` (T,
    N, 3) of the centre of mass, in world axes.
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
        """Return the index of the sample nearest to `time` (s)."""
        return int(np.abs(self.time - time).argmin())

    def poses(self, time: float) -> tuple[Pose, ...]:
        """Return the pose of every body at `time` (s), interpolated linearly between samples.

        Times within a microsecond of a sample use that sample. A body that moves further than its speed allows has been
        teleported and is not interpolated. In free fall the linear error is 0.02 mm.
        """
        i = self.sample(time)
        position, orientation = self.position[i], self.orientation[i]
        j = i + (1 if time > self.time[i] else -1)
        if abs(time - self.time[i]) > TIME_EPSILON and 0 <= j < len(self.time):
            part = (time - self.time[i]) / (self.time[j] - self.time[i])
            share = np.where(self._leaps(i, j), 0.0, part)[:, None]
            other = self.orientation[j]
            alike = (orientation * other).sum(axis=1, keepdims=True) >= 0  # -q is the same rotation
            position = position + share * (self.position[j] - position)
            orientation = orientation + share * (np.where(alike, other, -other) - orientation)
            orientation /= np.linalg.norm(orientation, axis=1, keepdims=True)
        return tuple(Pose(p, q) for p, q in zip(position, orientation, strict=True))

    def _leaps(self, i: int, j: int) -> NDArray[np.bool_]:
        """Return which bodies (N,) move more than twice as far between two samples as their speeds allow.

        The body frame is assumed to be within a metre of the centre of mass.
        """
        both = [i, j]
        speed = np.linalg.norm(self.linear_velocity[both], axis=2) + np.linalg.norm(self.angular_velocity[both], axis=2)
        reach = 2 * abs(self.time[j] - self.time[i]) * speed.max(axis=0) + 1e-3
        leaps: NDArray[np.bool_] = np.linalg.norm(self.position[j] - self.position[i], axis=1) > reach
        return leaps


class Renderer(Protocol):
    """Draws one scene any number of times. Close it after use."""

    def draw(self, shot: Shot, *, depth: bool = False) -> Frame:
        """Draw a picture."""
        ...

    def repaint(self, scene: Scene) -> bool:
        """Switch to `scene`, which differs in colours only. Return False if a new renderer is necessary."""
        ...

    def close(self) -> None:
        """Release all resources."""
        ...
