"""Native files run where there is nothing but the engine, and play what wmspec plays."""

from __future__ import annotations

from importlib.metadata import version
from pathlib import Path

import numpy as np
import pytest
from pxr import Usd

from tests.engines import ENGINES, installed
from tests.physics.test_native import limbs, lively
from tests.thirdparty.environments import python_with, run
from wmspec.sim.scene.model import Scene, Trace
from wmspec.sim.usd import read

MORE = {"pybullet": ("numpy",)}  # which it does not ask for itself


MADE = {"lively": lively, "limbs": limbs}


@pytest.mark.slow
@pytest.mark.parametrize("task", [*MADE, "collide", "slide"])
@pytest.mark.parametrize("engine", ENGINES)
def test_the_engine_is_enough(engine: str, task: str, catalogue: dict[str, list[Path]], tmp_path: Path) -> None:
    backend = installed(engine)
    scene = MADE[task]() if task in MADE else read(Usd.Stage.Open(str(catalogue[task][1])))
    for name, text in backend.native(scene).items():
        (tmp_path / name).write_text(text)
    alone = python_with(f"{engine}=={version(engine)}", *MORE.get(engine, ()))
    look = "import importlib.util; print(importlib.util.find_spec('wmspec'))"
    assert run(alone, "-c", look, folder=tmp_path).strip() == "None"
    run(alone, tmp_path / "run.py", folder=tmp_path)
    compare(tmp_path / "trace.npz", scene, backend.execute(scene))


def compare(file: Path, scene: Scene, expected: Trace) -> None:
    """The same trajectory to 1e-9, in SI units."""
    with np.load(file) as got:
        assert tuple(got["bodies"]) == tuple(body.name for body in scene.bodies)
        for field in ("time", "position", "orientation", "linear_velocity", "angular_velocity"):
            np.testing.assert_allclose(got[field], getattr(expected, field), rtol=0, atol=1e-9, err_msg=field)
