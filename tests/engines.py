"""The engines that the tests run in: those that wmspec brings, where they are installed."""

from __future__ import annotations

from importlib.util import find_spec
from typing import Any

import pytest

from tests.examples import slow_except
from wmspec.runtime.engines.registry import backend, info, names
from wmspec.sim.scene.backend import Backend

ENGINES = names()


def installed(engine: str) -> Backend:
    """The backend; the test is skipped where its engine is not installed."""
    if find_spec(info(engine).module) is None:
        pytest.skip(f"{info(engine).title} is not installed")
    return backend(engine)


def quick(*engines: str) -> list[Any]:
    """Every engine; those that are not named only where slow tests run."""
    return slow_except(engines, ENGINES)
