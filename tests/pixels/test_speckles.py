"""What is far away has no speckles: where a pixel covers many texels of an image, it is of their mean colour."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.pixels.scenes import body, scene
from tests.pixels.test_materials import surface
from wmspec.sim.materials import MATERIALS
from wmspec.sim.scene.model import Camera, Shot
from wmspec.sim.scene.render.camera import look_at
from wmspec.sim.scene.render.color import load_texture
from wmspec.sim.shapes import Box


@pytest.mark.parametrize("material", ["stone", "fabric", "wood"])
def test_a_far_top_is_smooth(material: str, engine: str, renderer: Any) -> None:
    eye = Camera("eye", look_at((0, -2, 0.3), (0, 0, 0)), math.radians(30), 0.05, 20.0)
    top = body("top", "static", (0, 0, -0.02), Box((0.5, 0.3, 0.02)), surface(MATERIALS[material]))
    frame = renderer(engine, scene(top, cameras=(eye,)), 96, 96).draw(Shot("eye", [top.pose]), depth=True)
    upper = (frame.ids == 0) & (frame.depth > 1.75)
    assert upper.sum() > 200
    grain = load_texture(str(MATERIALS[material].path))[..., 1]
    assert frame.rgb[upper][:, 1].std() < 0.2 * grain.std() + 1


@given(times=st.integers(0, 8), seed=st.integers(0, 99))
def test_halved_images_keep_their_mean(times: int, seed: int) -> None:
    images = pytest.importorskip("wmspec.backends.pybullet.images")
    image = np.random.default_rng(seed).integers(0, 256, (64, 128, 3)).astype(np.uint8)
    half = images.downsample(image, times)
    assert half.shape == (max(64 >> times, 1), max(128 >> times, 1), 3)
    assert np.abs(half.mean(axis=(0, 1)) - image.mean(axis=(0, 1))).max() < 1
    assert np.abs(images.smooth_tiled(half).mean(axis=(0, 1)) - half.mean(axis=(0, 1))).max() < 1
