"""The same scene gives the same bits, whatever ran before and wherever it runs."""

from __future__ import annotations

import hashlib
import subprocess
import sys
from functools import cache
from importlib import import_module
from pathlib import Path

import pytest

from tests.engines import ENGINES, installed
from tests.physics.scenes import G, body, floor, scene
from tests.physics.test_native import limbs, lively
from wmspec.sim.scene.model import Trace
from wmspec.sim.shapes import Box, Sphere

FIELDS = ("position", "orientation", "linear_velocity", "angular_velocity")


def digest(trace: Trace) -> str:
    """A fingerprint of every bit of a trace."""
    return hashlib.sha256(
        b"".join(getattr(trace, f).tobytes() for f in FIELDS) + repr(trace.contacts).encode()
    ).hexdigest()


@cache
def digests(engine: str) -> tuple[str, str]:
    """Those of two scenes, executed once in this process."""
    execute = installed(engine).execute
    return digest(execute(lively())), digest(execute(limbs()))


@pytest.mark.parametrize("engine", ENGINES)
def test_runs_do_not_depend_on_what_ran_before(engine: str) -> None:
    execute = installed(engine).execute
    first, second = digests(engine)
    other = scene(floor(0.9, 0.9), body("b", Sphere(0.1), (0, 0, 0.3), restitution=0.9), duration=0.2, gravity=G / 2)
    execute(other)
    assert digest(execute(lively())) == first
    assert digest(execute(limbs())) == second


@pytest.mark.parametrize("engine", ENGINES)
def test_processes_agree(engine: str) -> None:
    installed(engine)
    code = f"""
from wmspec.backends.{engine} import execute
from tests.physics.test_determinism import digest
from tests.physics.test_native import limbs, lively
print(digest(execute(lively())), digest(execute(limbs())), end="")
"""
    root = Path(__file__).parents[2]
    done = subprocess.run([sys.executable, "-c", code], cwd=root, capture_output=True, text=True, check=True)
    assert done.stdout == " ".join(digests(engine))  # also: engines print nothing of their own
    assert done.stderr == ""


@pytest.mark.parametrize("engine", ENGINES)
def test_nothing_is_left_behind(engine: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    installed(engine)
    errors = import_module("wmspec.core.diagnostics")
    execute = installed(engine).execute
    monkeypatch.chdir(tmp_path)
    wild = body("b", Box((0.05,) * 3), (0, 0, 1), velocity=(1e30, 0, 0), spin=(1e30, 1e30, 0))
    with pytest.raises(errors.EngineError):
        execute(scene(floor(), wild, duration=0.1))
    assert list(tmp_path.iterdir()) == []
