"""Near planes lie before all that is seen, and as far away as that allows: depths are known to micrometres."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.pixels.scenes import body, scene, turned
from wmspec.sim.scene.model import Camera, Scene, Shot, Surface
from wmspec.sim.scene.model.transform import rotation
from wmspec.sim.scene.render.camera import look_at, pixel_rays, project
from wmspec.sim.scene.render.near_plane import NearPlane
from wmspec.sim.shapes import Box

FAR = 3.9
GREY = Surface((0.5, 0.5, 0.5))
places = st.tuples(*[st.floats(-3, 3)] * 3)


def eye(at: Any, target: Any) -> Camera:
    return Camera("eye", look_at(at, target), math.radians(50), 0.05, 50.0)


@given(at=places, target=places, place=places, angle=st.floats(0, 3), wide=st.floats(0.05, 4), spot=places)
def test_nothing_in_the_picture_is_before_it(
    at: Any, target: Any, place: Any, angle: float, wide: float, spot: Any
) -> None:
    if np.linalg.norm(np.subtract(at, target)) < 0.1:
        return
    one = body("block", "static", place, Box((wide, 0.4, 0.1)), GREY, turn=turned(angle))
    what = scene(one, cameras=(eye(at, target),))
    camera = NearPlane(what, 1.0).before(what.cameras[0], Shot("eye", [one.pose]))
    inside = np.clip(np.array(spot) / 3, -1, 1) * (wide, 0.4, 0.1)
    pixels, depth = project(camera, one.pose.position + rotation(one.pose.orientation) @ inside, 100, 100)
    assert camera.near >= 0.05
    if 0.05 < depth[0] < 50 and (pixels > 0).all() and (pixels < 100).all():
        assert depth[0] > camera.near


def wall() -> Scene:
    """A wall 4 m away, and a floor that reaches below and behind the camera."""
    return scene(
        body("floor", "static", (0, 0, -1.05), Box((6, 6, 0.05)), GREY),
        body("wall", "static", (0, 0.1, 0), Box((3, 0.1, 3)), GREY),
        cameras=(eye((0, -FAR, 0), (0, 0, 0)),),
    )


def test_far_depth_is_accurate_to_micrometres(engine: str, renderer: Any) -> None:
    """The floor, whose triangles reach from behind the camera to the wall: distances follow from the pixels' rows."""
    what = wall()
    frame = renderer(engine, what, 128, 128).draw(Shot("eye", [one.pose for one in what.bodies]), depth=True)
    _, up = pixel_rays(what.cameras[0], 128, 128)
    with np.errstate(divide="ignore"):
        off = np.abs(frame.depth - (-1 / up)[:, None])[frame.ids == 0]
    assert len(off) > 2000
    assert off.max() < 2e-5


def test_near_objects_are_not_clipped(engine: str, renderer: Any) -> None:
    """A block comes from the wall to the camera: the same pixels as with a near plane that stays where it was."""
    block = body("block", "dynamic", (0, -0.5, 0), Box((0.05, 0.05, 0.05)), GREY)
    what = wall()
    what = replace(what, bodies=(*what.bodies, block))
    still = [one.pose for one in what.bodies[:2]]
    draw = renderer(engine, what, 64, 64).draw
    for away in (2.0, 0.5, 0.12):
        middle = np.array([0.0, away + 0.05 - FAR, 0.0])
        frame = draw(Shot("eye", [*still, replace(block.pose, position=middle)]), depth=True)
        assert frame.depth[32, 32] == pytest.approx(away, abs=1e-5)
        assert frame.ids[32, 32] == 2
