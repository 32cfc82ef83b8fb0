"""A sheet that is thinner than a texel of the shadow map is wide does not shade itself."""

from __future__ import annotations

import math
from itertools import combinations
from typing import Any

import numpy as np
import pytest

from tests.engines import ENGINES
from tests.pixels.scenes import body, scene
from wmspec.sim.scene.model import Camera, Frame, Shot, Surface
from wmspec.sim.scene.render.camera import look_at
from wmspec.sim.shapes import Box, Sphere


@pytest.fixture(scope="module")
def frames(renderer: Any) -> dict[str, Frame]:
    """A sheet on a board, and balls far to both sides, from every engine."""
    white, grey = Surface((0.9, 0.9, 0.9)), Surface((0.4, 0.4, 0.4))
    what = scene(
        body("board", "static", (0, 0, 0.5), Box((0.3, 0.02, 0.3)), grey),
        body("sheet", "static", (0, -0.02, 0.5), Box((0.2, 0.0015, 0.2)), white),
        *(body(f"ball{x}", "static", (x, 0, 0), Sphere(0.2), grey) for x in (-5, 5)),
        cameras=(Camera("eye", look_at((0.2, -1.2, 0.6), (0, 0, 0.5)), math.radians(30), 0.05, 20.0),),
    )
    shot = Shot("eye", [one.pose for one in what.bodies])
    return {engine: renderer(engine, what, 128, 128).draw(shot) for engine in ENGINES}


@pytest.mark.parametrize("pair", list(combinations(ENGINES, 2)), ids="-".join)
def test_a_sheet_has_the_same_colour(pair: tuple[str, str], frames: dict[str, Frame]) -> None:
    a, b = (frame.rgb[frame.ids == 1].mean(axis=0) for frame in (frames[engine] for engine in pair))
    assert np.abs(a - b).max() < 4
