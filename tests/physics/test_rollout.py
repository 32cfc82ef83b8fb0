"""MuJoCo left alone between events does what it does step by step, to the bit, contacts too."""

from __future__ import annotations

from typing import Any

import pytest

from tests.engines import installed
from tests.language.specs import SPECS, task_from, task_of
from wmspec.compile.design.design import Design
from wmspec.compile.stage.episode import document
from wmspec.compile.stage.layers import compose
from wmspec.sim.scene.model import Scene
from wmspec.sim.scene.physics.episode import play
from wmspec.sim.usd import read

LAUNCHED, DRIVEN = ("drop", "slide", "two_balls", "roll"), ("direction", "arm_drop", "collide")


def scene_of(task: str, place: int) -> Scene:
    """The first instance of a design, or the last."""
    spec = task_of(next(path for path in SPECS if path.stem == task))
    design = Design(spec)
    return read(compose(document(spec, design[place * (len(design) - 1)])))


@pytest.mark.parametrize("place", range(2))
@pytest.mark.parametrize("task", LAUNCHED)
def test_the_states_and_what_touches_are_the_same(task: str, place: int) -> None:
    installed("mujoco")
    from wmspec.backends.mujoco import physics, rollout
    from wmspec.backends.mujoco.mjcf import mjcf

    scene = scene_of(task, place)
    whole, timeline = physics.prepare(scene)
    assert rollout.is_uneventful(scene, timeline)
    text = rollout.with_contact_sensors(
        mjcf(scene, timeline, whole, seen=False), scene
    )  # what stands still and only shows is no matter
    with physics.suppress_log():
        slow = play(physics._world(mjcf(scene, timeline, whole), scene, whole, timeline), timeline)
        quick = rollout.play(physics._world(text, scene, whole, timeline), scene, timeline)
    assert quick.states.tobytes() == slow.states.tobytes()
    assert quick.touching == slow.touching
    assert any(slow.touching)


@pytest.mark.parametrize("task", DRIVEN)
def test_lasting_actions_are_stepped(task: str) -> None:
    installed("mujoco")
    from wmspec.backends.mujoco import physics, rollout

    scene = scene_of(task, 0)
    assert not rollout.is_uneventful(scene, physics.prepare(scene)[1])


STRUCK = """task struck : custom {{
  object floor {{ shape: box  size: (4 m, 4 m, 10 cm)  at: (0, 0, -5 cm)  fixed: true }}
  object wall  {{ shape: box  size: (10 cm, 40 cm, 40 cm)  on: floor at (0.5 m, 0)  fixed: true }}
  object door  {{ shape: box  size: (10 cm, 40 cm, 40 cm)  on: floor at ({}, -0.8 m) }}
  object ball  {{ shape: sphere  radius: 5 cm  on: floor at (-0.6 m, 0) }}
  action shut = glide(door, direction: 90 deg, speed: 4 m/s) for 0.2 s at 0.05 s
  action go = launch(ball, direction: 0 deg, speed: 2 m/s) at 0.3 s
  horizon 2.5 s
  camera front {{ at: (0, -3 m, 1 m) }}
  observe front at [0 s]
}}"""


@pytest.mark.parametrize("door", ["0.2 m", "1 m"])
def test_impact_on_a_prescribed_motion_is_stepped(door: str, monkeypatch: pytest.MonkeyPatch) -> None:
    installed("mujoco")
    from wmspec.backends.mujoco import physics, rollout
    from wmspec.backends.mujoco.mjcf import mjcf

    scene = read(compose(document(spec := task_from(STRUCK.format(door)), Design(spec)[0])))
    whole, timeline = physics.prepare(scene)
    assert rollout.is_uneventful(scene, timeline)
    text, struck, left_alone = mjcf(scene, timeline, whole, seen=False), [], rollout._advance

    def noted(*args: Any) -> Any:
        found = left_alone(*args)
        struck.append(found[2])
        return found

    monkeypatch.setattr(rollout, "_advance", noted)
    with physics.suppress_log():
        slow = play(physics._world(text, scene, whole, timeline), timeline)
        world = physics._world(rollout.with_contact_sensors(text, scene), scene, whole, timeline)
        quick = rollout.play(world, scene, timeline)
    assert quick.states.tobytes() == slow.states.tobytes()
    assert quick.touching == slow.touching
    assert any(struck) == (door == "0.2 m")
