"""What PyBullet's renderer gives, however PyBullet was compiled."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from tests.engines import installed
from tests.pixels.scenes import body, scene, views
from wmspec.runtime.engines.registry import backend
from wmspec.sim.scene.model import Frame, Shot, Surface
from wmspec.sim.shapes import Sphere


def drawn() -> Frame:
    what = scene(body("ball", "dynamic", (0.0, 0.0, 0.1), Sphere(0.1), Surface((0.8, 0.2, 0.1))), cameras=views())
    renderer = backend("pybullet").renderer(what, 48, 32)
    try:
        return renderer.draw(Shot("front", [one.pose for one in what.bodies]), depth=True)
    finally:
        renderer.close()


def test_pictures_are_the_same_where_they_come_as_tuples(monkeypatch: pytest.MonkeyPatch) -> None:
    """PyBullet that is compiled without NumPy in sight, as pip does of itself, has no arrays to give."""
    installed("pybullet")
    import pybullet

    arrays = drawn()
    image = pybullet.getCameraImage

    def flat(*arguments: Any, **options: Any) -> tuple[Any, ...]:
        width, height, *layers = image(*arguments, **options)
        return (width, height, *(tuple(layer.ravel().tolist()) for layer in map(np.asarray, layers)))

    monkeypatch.setattr(pybullet, "getCameraImage", flat)
    tuples = drawn()
    assert (arrays.ids == 0).any()
    assert np.array_equal(arrays.rgb, tuples.rgb)
    assert np.array_equal(arrays.ids, tuples.ids)
    assert arrays.depth is not None
    assert tuples.depth is not None
    assert np.array_equal(arrays.depth, tuples.depth)
