"""What rests sleeps in MuJoCo, and whatever moves it wakes it: all ends where it would have without sleeping."""

from __future__ import annotations

import numpy as np
import pytest

from tests.engines import installed
from tests.language.specs import task_from
from wmspec.compile.design.design import Design
from wmspec.compile.stage.episode import document
from wmspec.compile.stage.layers import compose
from wmspec.sim.scene.physics.episode import play
from wmspec.sim.usd import read

SCENE = """task still : custom {{
  object floor {{ shape: box  size: (4 m, 4 m, 10 cm)  at: (0, 0, -5 cm)  fixed: true }}
  object board {{ shape: box  size: (60 cm, 40 cm, 4 cm)  on: floor at (0, 0) }}
  object block {{ shape: cube  size: 10 cm  on: board at (0, 0)  friction: 0.6 }}
  object other {{ shape: cube  size: 10 cm  on: floor at (0, 1 m) }}
  object ball  {{ shape: sphere  radius: 5 cm  on: floor at (-1 m, 0)  density: 8000 kg/m^3 }}
  {happens}
  horizon 2 s
  camera front {{ at: (0, -3 m, 1 m) }}
  observe front at [0 s]
}}"""
WAKES = {
    "a launch": "action go = launch(board, direction: 0 deg, speed: 1.5 m/s) at 1 s",
    "a blow": "action go = impulse(block, direction: 0 deg, impulse: 0.8 N*s) at 1 s",
    "a force": "action go = force(block, direction: 0 deg, force: 8 N) for 0.5 s at 1 s",
    "what it stands on": "action go = glide(board, direction: 0 deg, speed: 30 cm/s) for 0.8 s at 1 s",
    "what strikes it": "action go = launch(ball, direction: 0 deg, speed: 2 m/s) at 1 s",
}


@pytest.mark.parametrize("happens", WAKES.values(), ids=WAKES)
def test_what_moves_wakes_what_slept(happens: str) -> None:
    installed("mujoco")
    from wmspec.backends.mujoco import physics
    from wmspec.backends.mujoco.mjcf import mjcf

    scene = read(compose(document(spec := task_from(SCENE.format(happens=happens)), Design(spec)[0])))
    whole, timeline = physics.prepare(scene)
    text, slept = mjcf(scene, timeline, whole), 0
    recordings = []
    for flag in ("enable", "disable"):
        world = physics._world(text.replace('sleep="enable"', f'sleep="{flag}"'), scene, whole, timeline)
        recordings.append(play(world, timeline))
        slept += int((world.data.tree_asleep >= 0).sum())
    asleep, awake = recordings
    names = [body.name for body in scene.bodies]
    moved = np.linalg.norm(awake.states[-1, :, :3] - awake.states[0, :, :3], axis=1)
    assert moved[names.index("block")] > 0.01
    assert slept > 0, "at least the other one sleeps"
    assert np.abs(asleep.states[..., :3] - awake.states[..., :3]).max() < 2e-4
    assert asleep.touching == awake.touching
