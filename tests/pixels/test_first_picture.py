"""The first pictures of a process are those that any later process, renderer or draw makes."""

import pickle
import subprocess
import sys
from pathlib import Path

import pytest

import wmspec
from tests.endtoend.test_commands import SPEED
from tests.engines import installed
from tests.shared import Shared
from wmspec.sim.scene.model import Scene, Shot
from wmspec.sim.usd import read

SCRIPT = """
import hashlib, pickle, sys
from wmspec.runtime.engines.registry import backend

engine = backend(sys.argv[1])
scene, shots = pickle.load(sys.stdin.buffer)
engine.execute(scene)
for _ in range(3):
    renderer = engine.renderer(scene, 64, 64)
    print(hashlib.sha256(b"".join(renderer.draw(shot).rgb.tobytes() for shot in shots)).hexdigest())
    renderer.close()
"""


def episode() -> tuple[Scene, list[Shot]]:
    """A scene, and what happens in it at four times."""
    scene = read(wmspec.load(SPEED)[1151].stage())
    trace = installed("pybullet").execute(scene)
    return scene, [Shot("front", trace.poses(t)) for t in (0.0, 0.7, 1.3, 2.0)]


@pytest.mark.parametrize("engine", ["mujoco", "pybullet", "sapien"])
def test_the_first_pictures_are_like_any_later(engine: str, shared: Shared) -> None:
    installed(engine)
    given = pickle.dumps(shared.value("first_picture", episode))
    command, here = [sys.executable, "-c", SCRIPT, engine], Path(__file__).parents[2]
    done = subprocess.run(command, cwd=here, input=given, capture_output=True, check=True)
    assert len(done.stdout.split()) == 3
    assert len(set(done.stdout.split())) == 1
