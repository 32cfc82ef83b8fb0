"""The first pictures of a process are those that any later process, renderer or draw makes."""

import subprocess
import sys
from pathlib import Path

import pytest

from tests.engines import installed

SCRIPT = """
import hashlib, sys
from tests.endtoend.test_commands import SPEED
from tests.language.specs import task_of
from wmspec.compile.design.design import Design
from wmspec.runtime.engines.registry import backend
from wmspec.sim.scene.model import Shot
from wmspec.sim.usd import read
from wmspec.compile.stage.episode import document
from wmspec.compile.stage.layers import compose

spec = task_of(SPEED)
engine = backend(sys.argv[1])
scene = read(compose(document(spec, Design(spec)[1151])))
trace = engine.execute(scene)
shots = [Shot("front", trace.poses(t)) for t in (0.0, 0.7, 1.3, 2.0)]
for _ in range(3):
    renderer = engine.renderer(scene, 64, 64)
    print(hashlib.sha256(b"".join(renderer.draw(shot).rgb.tobytes() for shot in shots)).hexdigest())
    renderer.close()
"""


@pytest.mark.parametrize("engine", ["mujoco", "pybullet", "sapien"])
def test_the_first_pictures_are_like_any_later(engine: str) -> None:
    installed(engine)
    command, here = [sys.executable, "-c", SCRIPT, engine], Path(__file__).parents[2]
    done = subprocess.run(command, cwd=here, capture_output=True, text=True, check=True)
    assert len(set(done.stdout.split())) == 1
