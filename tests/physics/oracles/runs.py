"""The episodes of an oracle's spec: every instance, through the stage, in one engine."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from wmspec.api import load
from wmspec.compile.design.design import Design
from wmspec.compile.design.levels import Level
from wmspec.compile.stage.episode import document
from wmspec.compile.stage.layers import compose
from wmspec.runtime.engines.registry import backend
from wmspec.sim.scene.model import Array, Body, Scene, Trace
from wmspec.sim.usd import read

FOLDER = Path(__file__).parent


@dataclass(frozen=True)
class Motion:
    """What a body did: `position`, `velocity`, `spin` (T, 3) and `orientation` (T, 4), of T samples."""

    body: Body
    position: Array
    orientation: Array
    velocity: Array
    spin: Array

    @property
    def mass(self) -> float:
        """Of a dynamic body, kg."""
        assert self.body.inertia is not None
        return self.body.inertia.mass


@dataclass(frozen=True)
class Run:
    """An executed instance and the values of its factors, in SI units."""

    factors: Mapping[str, Level]
    scene: Scene
    trace: Trace

    def __getitem__(self, name: str) -> Motion:
        """What the body of that name did."""
        i, t = self.trace.bodies.index(name), self.trace
        arrays = (t.position, t.orientation, t.linear_velocity, t.angular_velocity)
        return Motion(self.scene.bodies[i], *(a[:, i] for a in arrays))

    def factor(self, name: str) -> float:
        """The value of a factor that is a number."""
        value = self.factors[name]
        assert isinstance(value, float)
        return value

    @property
    def moving(self) -> list[Motion]:
        """The dynamic bodies."""
        return [self[b.name] for b in self.scene.bodies if b.motion == "dynamic"]


@cache
def runs(spec: str, engine: str) -> tuple[Run, ...]:
    """Every instance of a spec in an engine, in the order of the design."""
    task = load(FOLDER / f"{spec}.wms").spec
    found = []
    for instance in Design(task):
        scene = read(compose(document(task, instance)))
        found.append(Run(instance.values, scene, backend(engine).execute(scene)))
    return tuple(found)
