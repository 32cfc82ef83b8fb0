"""A case: a stage, its duration, and the criteria that the motion has to meet."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from usdphysics_conformance.quaternions import Array, rotate, rotation_vector

SAMPLE_RATE = 240
"""Samples a second of every trace."""


class ConformanceError(Exception):
    """A mistake of the user, such as an unknown case or a file that is not a trace; its text is one sentence."""


@dataclass(frozen=True)
class Motion:
    """The motion of one body in T samples.

    `position` (T, 3), m, and `orientation` (T, 4), quaternions (w, x, y, z), are those of its frame, whose origin is
    its centre of mass. `linear_velocity` (T, 3), m/s, and `angular_velocity` (T, 3), rad/s, are in world axes.
    """

    position: Array
    orientation: Array
    linear_velocity: Array
    angular_velocity: Array

    def speed(self, time: float) -> float:
        """The speed at a time (s), m/s."""
        return float(np.linalg.norm(self.linear_velocity[sample(time)]))

    def coordinate(self, time: float, axis: int) -> float:
        """A coordinate (axis 0, 1 or 2) at a time (s), m."""
        return float(self.position[sample(time), axis])

    def axis_direction(self, time: float, axis: int) -> Array:
        """The direction (3,) of an axis (0, 1 or 2) of the body at a time (s)."""
        return rotate(self.orientation[sample(time)], np.eye(3)[axis])

    def rotation_angle(self, time: float) -> float:
        """The angle (rad, 0 to pi) between the orientations at a time (s) and at the start."""
        return float(np.linalg.norm(rotation_vector(self.orientation[0], self.orientation[sample(time)])))


Trace = Mapping[str, Motion]
"""The motion of every rigid body of a stage, by the name of its prim."""


def sample(time: float) -> int:
    """The index of the sample at a time (s)."""
    return round(time * SAMPLE_RATE)


@dataclass(frozen=True)
class Criterion:
    """A number that mechanics gives for a motion.

    `measure` computes it from a trace. A trace passes if the result is within `tolerance` of `answer`, both in `unit`.
    `formula` and `source` say where the answer is from.
    """

    description: str
    answer: float
    tolerance: float
    unit: str
    measure: Callable[[Trace], float]
    formula: str
    source: str

    def record(self) -> dict[str, object]:
        """The criterion as plain values, for JSON."""
        about = {"measure": self.description, "answer": float(self.answer), "tolerance": self.tolerance}
        return {**about, "unit": self.unit, "formula": self.formula, "source": self.source}


@dataclass(frozen=True)
class Case:
    """A stage as text (.usda), how long to execute it (s), and its criteria."""

    name: str
    stage: str
    seconds: float
    criteria: tuple[Criterion, ...]

    @property
    def samples(self) -> int:
        """The number of samples of a trace, with those at the start and at the end."""
        return sample(self.seconds) + 1

    @cached_property
    def bodies(self) -> dict[str, str]:
        """The paths of the rigid bodies' prims on the stage, by the names of the prims."""
        from pxr import Usd, UsdPhysics

        stage = Usd.Stage.CreateInMemory()
        stage.GetRootLayer().ImportFromString(self.stage)
        prims = [prim for prim in stage.Traverse() if prim.HasAPI(UsdPhysics.RigidBodyAPI)]
        return {prim.GetName(): str(prim.GetPath()) for prim in prims}

    def record(self) -> dict[str, object]:
        """The case as plain values, for JSON, without its stage."""
        criteria = [criterion.record() for criterion in self.criteria]
        return {"case": self.name, "seconds": self.seconds, "bodies": list(self.bodies.values()), "criteria": criteria}


def make_case(name: str, stage: str, seconds: float, *criteria: Criterion) -> Case:
    """The case of these criteria."""
    return Case(name, stage, seconds, criteria)
