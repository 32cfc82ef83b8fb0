"""A scene with every shape, a colour each and a texture, and the engines that are installed."""

from __future__ import annotations

import importlib
from collections.abc import Iterator
from itertools import count
from typing import Any

import pytest

from tests.engines import ENGINES, installed
from tests.pixels.scenes import LYING, body, grain, riding, scene, turned, views, wedge
from wmspec.core.memoize import LRU
from wmspec.sim.scene.model import Scene, Surface
from wmspec.sim.shapes import Box, Capsule, Cone, Cylinder, Sphere


@pytest.fixture(scope="session")
def table(tmp_path_factory: pytest.TempPathFactory) -> Scene:
    """Every shape on a wooden table above a floor."""
    wood = Surface((1.0, 1.0, 1.0), texture=grain(tmp_path_factory.mktemp("looks") / "wood.png"))
    return scene(
        body("floor", "static", (0, 0, -0.75), Box((3.0, 3.0, 0.05)), Surface((0.72, 0.72, 0.70))),
        body("table", "static", (0, 0, -0.02), Box((0.45, 0.35, 0.02)), wood),
        body("ball", "dynamic", (-0.28, -0.05, 0.05), Sphere(0.05), Surface((0.80, 0.12, 0.12))),
        body("cube", "dynamic", (-0.1, 0.12, 0.05), Box((0.05,) * 3), Surface((0.13, 0.25, 0.80)), turn=turned(0.5)),
        body("cone", "dynamic", (0.10, -0.12, 0.06), Cone(0.05, 0.12), Surface((0.93, 0.78, 0.12))),
        body("can", "kinematic", (0.20, 0.12, 0.06), Cylinder(0.04, 0.12), Surface((0.12, 0.60, 0.25))),
        body("pill", "dynamic", (-0.08, -0.20, 0.03), Capsule(0.03, 0.08), Surface((0.50, 0.15, 0.60)), turn=LYING),
        body("ramp", "dynamic", (0.32, -0.08, 0.04), wedge(), Surface((0.95, 0.50, 0.10)), turn=turned(0.4)),
        cameras=(*views(), riding("can")),
    )


@pytest.fixture(scope="session")
def renderer() -> Iterator[Any]:
    """Make a renderer of an engine (or skip where it isn't installed); the last are kept open."""
    made: LRU[Any, Any] = LRU(8, drop=lambda one: one[0].close())
    numbers = count()

    def make(engine: str, what: Scene, width: int, height: int, fresh: bool = False) -> Any:
        installed(engine)
        key = (engine, id(what), width, height, next(numbers) if fresh else -1)
        module = importlib.import_module(f"wmspec.backends.{engine}.render")
        # The scene is kept, too: another one must not get its id.
        return made.get(key, lambda: (module.Renderer(what, width, height), what))[0]

    yield make
    made.clear()


@pytest.fixture(params=ENGINES)
def engine(request: pytest.FixtureRequest) -> str:
    """Each engine in turn."""
    return str(request.param)
