"""The engines in which most tests of physics run, one after another."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from tests.engines import ENGINES, installed
from wmspec.sim.scene.model import Scene, Trace

Execute = Callable[[Scene], Trace]


@pytest.fixture(params=ENGINES)
def engine(request: pytest.FixtureRequest) -> str:
    """The engine's name; tests of one that isn't installed are skipped."""
    installed(request.param)
    return str(request.param)


@pytest.fixture
def execute(engine: str) -> Execute:
    """The engine's `execute`."""
    run: Execute = installed(engine).execute
    return run
