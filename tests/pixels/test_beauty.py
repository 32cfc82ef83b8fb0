"""The beauty look: soft shadows, metal that mirrors a room, and masks as exact as ever."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from tests.engines import ENGINES, installed
from tests.pixels.scenes import body, scene
from wmspec.diagnostics import WmsError
from wmspec.execute.backends import backend
from wmspec.scene.camera import look_at, project
from wmspec.scene.environment import PEAK, cube, radiance
from wmspec.scene.model import Camera, Scene, Shot, Surface
from wmspec.scene.tonemap import tonemap
from wmspec.shapes import Box, Sphere

SIZE = 96


def metal() -> Scene:
    """A ball of steel and a red one on a floor."""
    floor = body("floor", "static", (0, 0, -0.05), Box((3.0, 3.0, 0.05)), Surface((0.7, 0.7, 0.7)))
    steel = body("steel", "dynamic", (-0.1, 0, 0.08), Sphere(0.08), Surface((0.9, 0.9, 0.9), 0.1, 1.0))
    paint = body("paint", "dynamic", (0.12, 0, 0.08), Sphere(0.08), Surface((0.8, 0.12, 0.12), 0.6))
    eye = Camera("eye", look_at((0, -0.8, 0.5), (0, 0, 0.05)), math.radians(30), 0.05, 10.0)
    return scene(floor, steel, paint, cameras=(eye,))


def shot(what: Scene) -> Shot:
    return Shot("eye", [one.pose for one in what.bodies])


@pytest.mark.parametrize("engine", ["mujoco", "sapien"])
def test_beauty(engine: str) -> None:
    installed(engine)
    what, made = metal(), backend(engine).renderer(metal(), SIZE, SIZE, "beauty", 4)
    plain = backend(engine).renderer(what, SIZE, SIZE)
    frame, parity = made.draw(shot(what), depth=True), plain.draw(shot(what), depth=True)
    again = made.draw(shot(what))
    made.close()
    plain.close()
    assert np.array_equal(frame.ids, parity.ids)
    assert np.array_equal(frame.depth, parity.depth)
    assert np.array_equal(frame.rgb, again.rgb)
    red = frame.rgb[frame.ids == 2].mean(axis=0)
    assert red[0] > 2 * red[1]
    assert parity.rgb[frame.ids == 1].max() < 235 < frame.rgb[frame.ids == 1].max(), "metal mirrors windows"
    (lit, shaded), _ = project(what.cameras[0], [(0.02, -0.15, 0), (0.215, 0.06, 0)], SIZE, SIZE)
    assert frame.ids[int(shaded[1]), int(shaded[0])] == 0
    bright, dark = (frame.rgb[int(y), int(x)].astype(float) for x, y in (lit, shaded))
    assert 110 < bright.mean() < 235
    assert dark.mean() < 0.85 * bright.mean()


def test_an_engine_without_the_look_says_so() -> None:
    installed("pybullet")
    with pytest.raises(WmsError, match="PyBullet can't draw the look 'beauty'; let another engine draw"):
        backend("pybullet").renderer(metal(), SIZE, SIZE, "beauty")


@pytest.mark.parametrize("engine", ENGINES)
def test_no_engine_draws_the_photo_look_itself(engine: str) -> None:
    installed(engine)
    with pytest.raises(WmsError, match="doesn't draw the look 'photo', Mitsuba does"):
        backend(engine).renderer(metal(), SIZE, SIZE, "photo")


def test_the_surroundings_are_as_bright_as_they_say() -> None:
    """The mean over the upper half is about 1, and what a cube map sums to is what the sphere has."""
    directions, side = cube(64), 64
    area: Any = 4 / side**2 * np.abs(directions).max(axis=-1) ** 3 / np.linalg.norm(directions, axis=-1) ** 3
    assert area.sum() == pytest.approx(4 * math.pi, rel=1e-2)
    light = radiance(directions)
    upper = directions[..., 2] > 0
    assert (light[upper] * area[upper, None]).sum() / 3 / (2 * math.pi) == pytest.approx(1, abs=0.15)
    assert light.max() <= PEAK


def test_developing_keeps_what_is_dark_and_rolls_off_what_is_bright() -> None:
    dark, bright = np.array([[[0.2, 0.5, 0.1]]]), np.linspace(0.1, 8, 50)[None, :, None] * np.ones(3)
    assert np.allclose(tonemap(dark)[0, 0], [124, 188, 89], atol=1)  # IEC 61966-2-1
    curve = tonemap(bright)[0, :, 0].astype(int)
    assert np.all(np.diff(curve) >= 0)
    assert curve[-1] <= 255
    assert np.unique(curve).size > 8
