"""What physics reads decides the trace, and nothing else: where a stage comes from and what it looks like do not."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from pxr import Usd

from tests.engines import ENGINES, installed
from tests.language.specs import SPECS, task_of
from tests.physics.test_determinism import digest
from tests.physics.test_native import limbs, lively
from wmspec.compile.design.design import Design
from wmspec.compile.stage.episode import document
from wmspec.compile.stage.layers import compose
from wmspec.compile.stage.write import write_stages
from wmspec.lang.check.ir.ir import Choices
from wmspec.runtime.caches.cache_keys import physics_key
from wmspec.runtime.caches.trace_cache import TraceCache
from wmspec.runtime.engines.registry import backend
from wmspec.sim.scene.model import Friction, Geom, Light, Scene, Surface
from wmspec.sim.usd import read

(COLLIDE,) = (task_of(path) for path in SPECS if path.stem == "collide")


def begun(stage: Usd.Stage) -> Scene:
    """A scene until a ball is on its way."""
    return replace(read(stage), duration=1.3)


def scene_of(index: int) -> Scene:
    """The beginning of an instance, through the stage."""
    return begun(compose(document(COLLIDE, Design(COLLIDE)[index])))


def twins() -> tuple[Scene, Scene]:
    """Two instances that differ in a colour."""
    here = Design(COLLIDE)[7]
    colors = COLLIDE.factor("box_color").domain
    assert isinstance(colors, Choices)
    other = next(color for color in colors.values if color != here.factors["box_color"])
    there = replace(here, factors=here.factors | {"box_color": other})
    return scene_of(7), begun(compose(document(COLLIDE, there)))


@pytest.mark.parametrize("engine", ENGINES)
def test_twins_share_one_trace(engine: str) -> None:
    installed(engine)
    one, other = twins()
    executor = TraceCache(engine)
    assert executor.trace(one) is executor.trace(other)


@pytest.mark.parametrize(("times", "executed"), [(1, 4), (2, 2)])
def test_the_cache_holds_a_number_of_bytes(times: int, executed: int) -> None:
    """Two scenes in turn, twice, where `times` traces of the size of the first have room."""
    installed("mujoco")
    first, second = scene_of(7), scene_of(8)
    size = sum(a.nbytes for a in vars(TraceCache("mujoco").trace(first)).values() if isinstance(a, np.ndarray))
    executor = TraceCache("mujoco", times * size)
    for scene in (first, second, first, second):
        executor.trace(scene)
    assert executor.executed == executed


@pytest.mark.parametrize("engine", ENGINES)
def test_twins_may_share_a_file(engine: str) -> None:
    """Executed one by one they give the same bits."""
    installed(engine)
    first, second = (digest(backend(engine).execute(scene)) for scene in twins())
    assert first == second


@pytest.mark.parametrize("engine", ENGINES)
def test_a_stage_from_the_disk_gives_the_same_bits(engine: str, tmp_path: Path) -> None:
    installed(engine)
    design = Design(COLLIDE)
    stage = next(path for path in write_stages(design, design[7], tmp_path) if path.name == "000007.usda")
    written = begun(Usd.Stage.Open(str(stage)))
    assert physics_key(written) == physics_key(scene_of(7))
    assert digest(backend(engine).execute(written)) == digest(backend(engine).execute(scene_of(7)))


def geoms(scene: Scene, change: Callable[[Geom], Geom]) -> Scene:
    """The scene with its second body's geometries changed."""
    bodies = list(scene.bodies)
    bodies[1] = replace(bodies[1], geoms=tuple(change(geom) for geom in bodies[1].geoms))
    return replace(scene, bodies=tuple(bodies))


LOOKS: dict[str, Callable[[Scene], Scene]] = {
    "surface": lambda s: geoms(s, lambda g: replace(g, surface=Surface((0.1, 0.2, 0.3), 0.9))),
    "light": lambda s: replace(s, light=Light(np.array([0, 0, -1.0]), 0.5, 0.5)),
    "background": lambda s: replace(s, background=(0, 0, 0)),
    "cameras": lambda s: replace(s, cameras=(), observations=()),
}
PHYSICS: dict[str, Callable[[Scene], Scene]] = {
    "gravity": lambda s: replace(s, gravity=s.gravity * 0.5),
    "duration": lambda s: replace(s, duration=s.duration + 0.1),
    "rate": lambda s: replace(s, rate=480),
    "actions": lambda s: replace(s, actions=s.actions[:-1]),
    "filtered": lambda s: replace(s, filtered=((s.bodies[1].name, s.bodies[2].name),)),
    "order": lambda s: replace(s, bodies=s.bodies[::-1]),
    "friction": lambda s: geoms(s, lambda g: replace(g, friction=Friction(0.11, 0.11, 0.0))),
    "collision": lambda s: geoms(s, lambda g: replace(g, collides=False)),
    "place": lambda s: replace(
        s, bodies=(*s.bodies[:-1], replace(s.bodies[-1], pose=replace(s.bodies[-1].pose, position=np.ones(3))))
    ),
}


@pytest.mark.parametrize("look", LOOKS)
def test_looks_are_not_read(look: str) -> None:
    assert physics_key(LOOKS[look](lively())) == physics_key(lively())


@pytest.mark.parametrize("part", PHYSICS)
def test_physics_is_read(part: str) -> None:
    assert physics_key(PHYSICS[part](lively())) != physics_key(lively())


def test_joints_are_read() -> None:
    assert physics_key(replace(limbs(), joints=limbs().joints[:-1])) != physics_key(limbs())
    assert physics_key(limbs()) == physics_key(limbs())
