"""MuJoCo left alone between events does what it does step by step, to the bit, contacts too."""

from __future__ import annotations

from dataclasses import replace

import pytest

from tests.engines import installed
from tests.language.specs import SPECS, task_of
from wmspec.design.design import Design
from wmspec.scene.episode import play
from wmspec.scene.model import Scene
from wmspec.stage.episode import document
from wmspec.stage.layers import compose
from wmspec.usd import read

LAUNCHED, DRIVEN = ("collide", "drop", "slide", "two_balls"), ("direction", "arm_drop")


def scene_of(task: str, place: int) -> Scene:
    """The first instance of a design, or the last; its bystander stays: walks are stepped from Python."""
    spec = task_of(next(path for path in SPECS if path.stem == task))
    design = Design(spec)
    scene = read(compose(document(spec, design[place * (len(design) - 1)])))
    bodies = tuple(replace(body, motion="static") if body.name == "stander" else body for body in scene.bodies)
    return replace(scene, bodies=bodies, actions=tuple(a for a in scene.actions if a.body != "stander"))


@pytest.mark.parametrize("place", range(2))
@pytest.mark.parametrize("task", LAUNCHED)
def test_the_states_and_what_touches_are_the_same(task: str, place: int) -> None:
    installed("mujoco")
    from wmspec.backends.mujoco import physics, rollout
    from wmspec.backends.mujoco.mjcf import mjcf

    scene = scene_of(task, place)
    whole, timeline = physics.prepare(scene)
    assert rollout.uneventful(scene, timeline)
    text = rollout.sensed(
        mjcf(scene, timeline, whole, seen=False), scene
    )  # what stands still and only shows is no matter
    with physics.unlogged():
        slow = play(physics._world(mjcf(scene, timeline, whole), scene, whole, timeline), timeline)
        quick = rollout.play(physics._world(text, scene, whole, timeline), scene, timeline)
    assert quick.states.tobytes() == slow.states.tobytes()
    assert quick.touching == slow.touching
    assert any(slow.touching)


@pytest.mark.parametrize("task", DRIVEN)
def test_what_lasts_is_made_step_by_step(task: str) -> None:
    installed("mujoco")
    from wmspec.backends.mujoco import physics, rollout

    scene = scene_of(task, 0)
    assert not rollout.uneventful(scene, physics.prepare(scene)[1])
