"""What rests is not stepped, and whatever moves it wakes it: all ends where it would have with every step."""

from __future__ import annotations

from itertools import product
from typing import Any

import numpy as np
import pytest

from tests.engines import installed
from tests.examples import slow_except
from tests.language.specs import task_from
from wmspec.compile.design.design import Design
from wmspec.compile.stage.episode import document
from wmspec.compile.stage.layers import compose
from wmspec.sim.scene.model.transform import rotate
from wmspec.sim.scene.physics import rest
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

#: MuJoCo does not sleep while a body is held.
RELEASE = {"its release": "action go = drop(block, height: 20 cm) at 1 s"}


@pytest.mark.parametrize("happens", WAKES.values(), ids=WAKES)
def test_moving_body_wakes_a_sleeping_one(happens: str) -> None:
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


#: In SAPIEN, the others run where slow tests run: what leaves steps out is one for both engines.
IN_SAPIEN = ("what strikes it", "its release")


@pytest.mark.parametrize(
    ("name", "engine"),
    slow_except(
        {*product(WAKES | RELEASE, ["pybullet"]), *product(IN_SAPIEN, ["sapien"])},
        product(WAKES | RELEASE, ("pybullet", "sapien")),
    ),
)
def test_engines_without_sleep_leave_out_the_steps_that_change_nothing(
    engine: str, name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    backend, happens = installed(engine), (WAKES | RELEASE)[name]
    scene = read(compose(document(spec := task_from(SCENE.format(happens=happens)), Design(spec)[0])))
    leave_out, left_out = rest.Rest.leave_out, list[int]()

    def counted(self: rest.Rest, *step: Any) -> int:
        left_out.append(leave_out(self, *step))
        return left_out[-1]

    with monkeypatch.context() as patched:
        patched.setattr(rest, "REST_CHECKS", 10**9)
        every = backend.execute(scene)
    monkeypatch.setattr(rest.Rest, "leave_out", counted)
    some = backend.execute(scene)
    assert sum(left_out) > 0.25 * left_out.count(0), "the first second, at least"
    assert np.abs(every.position - every.position[0]).max() > 0.01
    assert np.abs(some.position - every.position).max() < 2e-4
    assert {(c.first, c.second) for c in some.contacts} == {(c.first, c.second) for c in every.contacts}


@pytest.mark.parametrize("engine", ["pybullet", "sapien"])
def test_falling_bodies_are_stepped(engine: str) -> None:
    """A board that lies 0.3 mm beyond its balance starts slower than anything that is seen to move."""
    backend = installed(engine)
    tilting = """task still : custom {
      object block { shape: cube  size: 40 cm  at: (0, 0, 20 cm)  fixed: true }
      object board { shape: box  size: (60 cm, 40 cm, 4 cm)  at: (20.03 cm, 0, 42 cm) }
      horizon 4 s
      camera front { at: (0, -3 m, 1 m) }
      observe front at [0 s]
    }"""
    scene = read(compose(document(spec := task_from(tilting), Design(spec)[0])))
    trace = backend.execute(scene)
    assert trace.position[-1, trace.bodies.index("board"), 2] < 0.3


def test_the_gap_of_boxes_is_never_overestimated() -> None:
    generator = np.random.default_rng(7)
    grid = np.stack(np.meshgrid(*[np.linspace(0, 1, 5)] * 3), axis=-1).reshape(-1, 3)
    for _ in range(200):
        low = generator.uniform(-0.2, 0, (2, 3))
        boxes = [np.stack([a, a + generator.uniform(0.02, 0.4, 3)]) for a in low]
        poses = np.concatenate([generator.uniform(-0.5, 0.5, (2, 3)), generator.normal(size=(2, 4))], axis=1)
        poses[:, 3:] /= np.linalg.norm(poses[:, 3:], axis=1, keepdims=True)
        one, other = (
            pose[:3] + rotate(pose[3:], box[0] + grid * (box[1] - box[0]))
            for box, pose in zip(boxes, poses, strict=True)
        )
        sampled = np.linalg.norm(one[:, None] - other[None], axis=2).min()
        bound = rest.box_distance(boxes[0], poses[:1], boxes[1], poses[1])
        assert bound[0] <= sampled + 1e-9
