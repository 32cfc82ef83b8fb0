"""Soft contact shadows: what a sphere hides of the light is known, and nothing else is darker than before."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from tests.pixels.scenes import body, scene
from wmspec.sim.scene.model import Camera, Light, Scene, Shot, Surface
from wmspec.sim.scene.render.camera import look_at, unproject
from wmspec.sim.scene.render.contact_shadow import SHADOW_REACH, STRENGTH, ContactShadows
from wmspec.sim.shapes import Box, Sphere

RADIUS, SIZE = 0.1, 101
EYE = Camera("eye", look_at((0, 0, 2), (0, 0, 0)), math.radians(30), 0.01, 10)


def ball(high: float = 0.0) -> Scene:
    """A ball over a floor."""
    return scene(
        body("floor", "static", (0, 0, -0.05), Box((3.0, 3.0, 0.05)), Surface()),
        body("ball", "dynamic", (0, 0, RADIUS + high), Sphere(RADIUS), Surface()),
        cameras=(EYE,),
    )


def shaded(what: Scene, depth: float = 2.0, seen: int = 0) -> NDArray[np.uint8]:
    """What becomes of a white picture of nothing but a flat body, `seen`, that faces the camera at a distance."""
    white, ids = np.full((SIZE, SIZE, 3), 255, np.uint8), np.full((SIZE, SIZE), seen, np.int16)
    shot = Shot("eye", [one.pose for one in what.bodies])
    return ContactShadows(what).cast(white, ids, np.full((SIZE, SIZE), depth, np.float32), EYE, shot)


def test_floor_loses_the_light_that_a_sphere_hides() -> None:
    places = unproject(EYE, np.full((SIZE, SIZE), 2.0, np.float32))
    away = np.hypot(np.hypot(places[..., 0], places[..., 1]), RADIUS)
    share = np.clip((RADIUS**2 / away**2 - SHADOW_REACH**-2) / (1 - SHADOW_REACH**-2), 0, 1) * RADIUS / away
    assert np.abs(shaded(ball())[..., 0] - 255 * (1 - STRENGTH * share)).max() < 1.5


@pytest.mark.parametrize("high", [0.31, 1.0])
def test_high_bodies_cast_no_contact_shadow(high: float) -> None:
    assert (shaded(ball(high)) == 255).all()


def test_no_contact_shadow_far_behind() -> None:
    assert (shaded(ball(), depth=2.5) == 255).all()


def test_nothing_shades_itself_or_the_background() -> None:
    assert (shaded(ball(), seen=1) == 255).all()
    assert (shaded(ball(), depth=0.0, seen=-1) == 255).all()


def test_light_without_shadows_has_none() -> None:
    what = ball()
    dull = replace(what, light=Light(what.light.direction, shadows=False))
    assert (shaded(dull) == 255).all()
