"""MuJoCo makes no steps while all that can move sleeps and nothing comes near: to the bit what it makes of them."""

from __future__ import annotations

from itertools import product
from typing import Any

import numpy as np
import pytest

from tests.engines import installed
from tests.examples import slow_except
from tests.language.specs import SPECS, task_of
from wmspec.compile.design.design import Design
from wmspec.compile.stage.episode import document
from wmspec.compile.stage.layers import compose
from wmspec.sim.scene.model.transform import rotate
from wmspec.sim.scene.physics.episode import play
from wmspec.sim.usd import read

TASKS = ("domino_row", "arm_push", "arms_push", "arm_drop")
QUICK = [("domino_row", 0), ("domino_row", 1), ("arm_push", 0), ("arm_drop", 1)]


class Counted:
    """MuJoCo, whose steps are counted."""

    def __init__(self, engine: Any) -> None:
        self.engine, self.steps = engine, 0

    def __getattr__(self, name: str) -> Any:
        return getattr(self.engine, name)

    def mj_step(self, model: Any, data: Any) -> None:
        self.steps += 1
        self.engine.mj_step(model, data)


@pytest.mark.parametrize(("task", "place"), slow_except(QUICK, product(TASKS, range(2))))
def test_omitted_bodies_have_no_effect(task: str, place: int, monkeypatch: pytest.MonkeyPatch) -> None:
    installed("mujoco")
    from wmspec.backends.mujoco import physics, world
    from wmspec.backends.mujoco.mjcf import mjcf

    design = Design(spec := task_of(next(path for path in SPECS if path.stem == task)))
    scene = read(compose(document(spec, design[place * (len(design) - 1)])))
    whole, timeline = physics.prepare(scene)
    text, recordings, made = mjcf(scene, timeline, whole, seen=False), [], []
    counted = Counted(world.mujoco)
    monkeypatch.setattr(world, "mujoco", counted)
    for clear in (world.is_clear, lambda model, data, paths, first: np.zeros(len(next(iter(paths.values()))), bool)):
        monkeypatch.setattr(world, "is_clear", clear)
        counted.steps = 0
        with physics.suppress_log():
            recordings.append(play(physics._world(text, scene, whole, timeline), timeline))
        made.append(counted.steps)
    some, every = recordings
    assert some.states.tobytes() == every.states.tobytes()
    assert some.touching == every.touching
    assert some.broken_grips == every.broken_grips
    assert made[0] < made[1] == len(every.touching)


SHAPES = {
    "sphere": 'type="sphere" size="0.1"',
    "box": 'type="box" size="0.1 0.3 0.05" pos="0.1 0 0.2" euler="10 20 30"',
    "cylinder": 'type="cylinder" size="0.05 0.2" euler="40 0 10"',
    "capsule": 'type="capsule" size="0.05 0.2"',
    "mesh": 'type="mesh" mesh="wedge" pos="0 0.1 0" euler="0 50 20"',
}
TWO = """<mujoco><asset><mesh name="wedge" vertex="0 0 0  .3 0 0  0 .2 0  0 0 .4" inertia="convex"/></asset><worldbody>
<body><freejoint/><geom name="a" {}/></body><body><freejoint/><geom name="b" {}/></body>
</worldbody><contact><pair geom1="a" geom2="b" gap="0.002"/></contact></mujoco>"""


@pytest.mark.parametrize("reported", SHAPES.values(), ids=SHAPES)
@pytest.mark.parametrize("other", SHAPES.values(), ids=SHAPES)
def test_clear_of_excludes_contact(reported: str, other: str) -> None:
    installed("mujoco")
    import mujoco

    from wmspec.backends.mujoco.clearance import is_clear

    rng, clear, steps = np.random.default_rng(0), 0, 200
    model = mujoco.MjModel.from_xml_string(TWO.format(reported, other))
    data = mujoco.MjData(model)
    for _ in range(3):
        path = np.concatenate([rng.uniform(-0.5, 0.5, (steps, 3)), rng.normal(size=(steps, 4))], axis=1)
        path[:, 3:] /= np.linalg.norm(path[:, 3:], axis=1, keepdims=True)
        for moves, first in ((1, 0), (2, 7)):
            mujoco.mj_kinematics(model, data)
            apart = is_clear(model, data, {moves: path}, 0)
            clear += int(apart.sum())
            for pose, separate in zip(path, apart.tolist(), strict=True):
                data.qpos[first : first + 7] = pose
                mujoco.mj_fwdPosition(model, data)
                assert not (separate and data.ncon)
            at = rotate(pose[3:], model.geom_pos[moves - 1]) + pose[:3]
            assert np.allclose(at, data.geom_xpos[moves - 1]), "paths are those of the bodies' frames"
    assert clear > 0.2 * steps * 6
