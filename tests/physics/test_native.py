"""The native form needs the engine only, and plays what `execute` plays."""

from __future__ import annotations

import builtins
import os
import subprocess
import sys
from collections.abc import Callable, Iterator
from dataclasses import replace
from itertools import product
from pathlib import Path
from symtable import SymbolTable, symtable

import numpy as np
import pytest

from tests.engines import ENGINES, installed
from tests.examples import slow_except
from tests.physics.scenes import UPRIGHT, body, floor, scene, turn
from tests.physics.test_joints import joint, rod
from wmspec.sim.scene.model import (
    Drive,
    Follow,
    Force,
    Glide,
    Impulse,
    Launch,
    PassThrough,
    Release,
    Scene,
    Steer,
    Teleport,
)
from wmspec.sim.shapes import Box, Capsule, Cone, Cylinder, Sphere

RISE = np.array([[0.8, 0, 0.021], [0.8, 0, 0.1], [0.8, 0.05, 0.1]])


def lively() -> Scene:
    """Every shape but meshes, every action on bodies, damping, an offset centre of mass, two materials."""
    bodies = (
        floor(),
        body("ball", Sphere(0.05), (-0.3, 0, 0.05), mass=0.2, restitution=0.4),
        body("block", Box((0.05, 0.04, 0.03)), (0, 0.01, 0.03), angular_damping=0.3, linear_damping=0.1),
        body("cone", Cone(0.05, 0.1), (0.3, 0, 0.1), orientation=turn((0, 1, 0), 0.3), friction=0.8),
        body("can", Cylinder(0.04, 0.1), (0, 0.4, 0.05)),
        body("pill", Capsule(0.03, 0.08), (0.2, 0.4, 0.2), spin=(1, 2, 3)),
        body("pusher", Box((0.02, 0.1, 0.05)), (-0.2, 0.4, 0.051), motion="kinematic"),
        body("lift", Box((0.1, 0.1, 0.02)), (0.8, 0, 0.021), motion="kinematic"),
        body("load", Box((0.03, 0.03, 0.03)), (0.8, 0, 0.071)),
        body("bomb", Box((0.03, 0.03, 0.03)), (0, 0, 0.3), orientation=turn((1, 0, 0), 0.3)),
    )
    actions = (
        Launch("throw", "ball", 0.1, np.array([1.3, 0, 0]), np.zeros(3)),
        Glide("push", "pusher", 0.05, 0.45, np.array([0.5, 0.0, 0.0])),
        Follow("rise", "lift", 0.05, np.array([0, 0.1, 0.2]), RISE, np.array([UPRIGHT, turn((0, 1, 0), 0.2), UPRIGHT])),
        Teleport("away", "lift", 0.4, np.array([1.5, 0, 0.3]), UPRIGHT),
        Teleport("jump", "pill", 0.3, np.array([0.5, 0.6, 0.3])),
        Force("draught", "can", 0.1, 0.3, np.array([0, 3.0, 0])),
        Impulse("hit", "pill", 0.2, np.array([0, 0.05, 0.1])),
        Release("drop", "bomb", 0.15),
        PassThrough("ghost", "bomb", "block", 0.3, 0.45),
    )
    return scene(*bodies, duration=0.5, actions=actions)


def limbs() -> Scene:
    """Joints of every kind, a tree that hangs and one that floats, a drive that is steered, damping, filtered pairs."""
    hanging = [rod(f"rod{i}", at=(0, 0, 1.5 - 0.4 * i), length=0.4) for i in range(3)]
    hanging[0] = replace(hanging[0], linear_damping=0.1, angular_damping=0.2)
    boxes = [body(f"box{i}", Box((0.05,) * 3), (0.5 + 0.12 * i, 0, 0.2)) for i in range(4)]
    ball = body("ball", Sphere(0.05), (0.5, 0.02, 0.5), friction=0.3)
    joints = (
        joint("top", "hinge", None, hanging[0], (0, 0, 1.5)),
        joint("knee", "ball", hanging[0], hanging[1], (0, 0, 1.1)),
        joint("foot", "hinge", hanging[2], hanging[1], (0, 0, 0.7), limits=(-0.1, 0.2)),
        joint("weld", "fixed", boxes[0], boxes[1], (0.56, 0, 0.2)),
        joint("rail", "slider", boxes[1], boxes[2], (0.68, 0, 0.2), UPRIGHT, drive=Drive(200, 5, 0.05, max_force=30)),
        joint("loose", "ball", boxes[2], boxes[3], (0.80, 0, 0.2)),
    )
    actions = (
        Impulse("hit", "rod0", 0.05, np.array([0.5, 0.2, 0])),
        Steer("go", "rail", 0.2, 0.02),
        Release("drop", "box1", 0.1),
    )
    whole = scene(floor(), *hanging, *boxes, ball, duration=0.5, joints=joints, actions=actions)
    return replace(whole, filtered=(("box0", "ball"),))


#: An engine runs one of them here, and the other where slow tests run.
PLAYED = [("mujoco", limbs), ("pybullet", lively), ("sapien", limbs)]


@pytest.mark.parametrize(("engine", "play"), slow_except(PLAYED, product(ENGINES, (lively, limbs))))
def test_the_native_script_plays_the_same_episode(engine: str, play: Callable[[], Scene], tmp_path: Path) -> None:
    backend = installed(engine)
    expected = backend.execute(play())
    for name, text in backend.native(play()).items():
        assert "wmspec" not in text
        (tmp_path / name).write_text(text)
    clean = {key: value for key, value in os.environ.items() if key != "PYTHONPATH"}
    command = [sys.executable, str(tmp_path / "run.py")]
    done = subprocess.run(command, check=False, cwd=tmp_path, env=clean, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    with np.load(tmp_path / "trace.npz") as got:
        assert tuple(got["bodies"]) == expected.bodies
        for field in ("time", "position", "orientation", "linear_velocity", "angular_velocity"):
            assert np.allclose(got[field], getattr(expected, field), rtol=0, atol=1e-9), field


@pytest.mark.parametrize("engine", ENGINES)
def test_the_native_script_contains_every_name_that_it_uses(engine: str) -> None:
    """Also what only an engine's warning would call."""
    whole = symtable(installed(engine).native(limbs())["run.py"], "run.py", "exec")
    own = {symbol.get_name() for symbol in whole.get_symbols() if symbol.is_assigned() or symbol.is_imported()}
    assert "World" in own
    assert set(_globals(whole)) - own - set(dir(builtins)) == {"__file__"}


def _globals(table: SymbolTable) -> Iterator[str]:
    """Names that a scope and those within it take from the module."""
    yield from (symbol.get_name() for symbol in table.get_symbols() if symbol.is_global() and symbol.is_referenced())
    for inner in table.get_children():
        yield from _globals(inner)


def test_the_model_opens_in_mujoco_by_itself(tmp_path: Path) -> None:
    mujoco = pytest.importorskip("mujoco")
    backend = installed("mujoco")
    (tmp_path / "scene.xml").write_text(backend.native(lively())["scene.xml"])
    model = mujoco.MjModel.from_xml_path(str(tmp_path / "scene.xml"))
    assert [model.body(i + 1).name for i in range(model.nbody - 1)] == [b.name for b in lively().bodies]
    assert model.nkey == 1
    assert model.key_qvel.any()
    (tmp_path / "limbs.xml").write_text(backend.native(limbs())["scene.xml"])
    model = mujoco.MjModel.from_xml_path(str(tmp_path / "limbs.xml"))
    assert (model.njnt, model.nu) == (7, 1)  # all but the weld, and two that are free
