"""A case: a stage, how long it lasts, and what mechanics says of it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from wmspec.sim.scene.model import Array
from wmspec.sim.scene.model.transform import rotate, turned

RATE = 240  # samples a second


@dataclass(frozen=True)
class Track:
    """The way of one body, T samples.

    `position` (T, 3) m and `orientation` (T, 4) of its frame, which is at its centre of mass, and velocities (T, 3),
    m/s and rad/s, in world axes.
    """

    position: Array
    orientation: Array
    velocity: Array
    spin: Array

    def speed(self, time: float) -> float:
        """How fast it is, m/s."""
        return float(np.linalg.norm(self.velocity[sample(time)]))

    def at(self, time: float, axis: int) -> float:
        """A coordinate, m."""
        return float(self.position[sample(time), axis])

    def axis(self, time: float, axis: int) -> Array:
        """Where an axis (0, 1, 2) of the body points (3,)."""
        return rotate(self.orientation[sample(time)], np.eye(3)[axis])

    def turn(self, time: float) -> float:
        """By how much (rad, 0..pi) it has turned since the start."""
        from wmspec.sim.scene.model.transform import conjugate, multiply

        whole = multiply(self.orientation[sample(time)], conjugate(self.orientation[0]))
        return float(np.linalg.norm(turned(whole)))


Run = Mapping[str, Track]
"""What an engine made of a stage: its moving bodies by the names of their prims."""


def sample(time: float) -> int:
    """The number of the sample at a time (s)."""
    return round(time * RATE)


@dataclass(frozen=True)
class Measure:
    """A number that mechanics knows.

    `answer` and how far an engine may be off, both in `unit`; how it is measured of a run; the formula and where it is
    from.
    """

    what: str
    answer: float
    tolerance: float
    unit: str
    of: Callable[[Run], float]
    formula: str
    source: str


@dataclass(frozen=True)
class Case:
    """A stage as text, in SI units unless it says otherwise, that lasts `seconds`."""

    name: str
    stage: str
    seconds: float
    measures: tuple[Measure, ...]
