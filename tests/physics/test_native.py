"""The native form needs the engine only, and plays what `execute` plays."""

from __future__ import annotations

import os
import subprocess
import sys
from importlib import import_module
from pathlib import Path

import numpy as np
import pytest

from tests.physics.scenes import ENGINES, body, floor, scene, turn
from wmspec.scene.model import Box, Capsule, Cone, Cylinder, Glide, Launch, Scene, Sphere


def lively() -> Scene:
    """Every shape but meshes, both actions, damping, an offset centre of mass, two materials."""
    bodies = (
        floor(),
        body("ball", Sphere(0.05), (-0.3, 0, 0.05), mass=0.2, restitution=0.4),
        body("block", Box(np.array([0.05, 0.04, 0.03])), (0, 0.01, 0.03), angular_damping=0.3, linear_damping=0.1),
        body("cone", Cone(0.05, 0.1), (0.3, 0, 0.1), orientation=turn((0, 1, 0), 0.3), friction=0.8),
        body("can", Cylinder(0.04, 0.1), (0, 0.4, 0.05)),
        body("pill", Capsule(0.03, 0.08), (0.2, 0.4, 0.2), spin=(1, 2, 3)),
        body("pusher", Box(np.array([0.02, 0.1, 0.05])), (-0.2, 0.4, 0.051), motion="kinematic"),
    )
    actions = (
        Launch("throw", "ball", 0.1, np.array([1.3, 0, 0]), np.zeros(3)),
        Glide("push", "pusher", 0.05, 0.45, np.array([0.5, 0.0, 0.0])),
    )
    return scene(*bodies, duration=0.5, actions=actions)


@pytest.mark.parametrize("engine", ENGINES)
def test_the_native_script_plays_the_same_episode(engine: str, tmp_path: Path) -> None:
    pytest.importorskip(engine)
    backend = import_module(f"wmspec.backends.{engine}")
    expected = backend.execute(lively())
    for name, text in backend.native(lively()).items():
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


def test_the_model_opens_in_mujoco_by_itself(tmp_path: Path) -> None:
    mujoco = pytest.importorskip("mujoco")
    backend = import_module("wmspec.backends.mujoco")
    (tmp_path / "scene.xml").write_text(backend.native(lively())["scene.xml"])
    model = mujoco.MjModel.from_xml_path(str(tmp_path / "scene.xml"))
    assert [model.body(i + 1).name for i in range(model.nbody - 1)] == [b.name for b in lively().bodies]
    assert model.nkey == 1
    assert model.key_qvel.any()
