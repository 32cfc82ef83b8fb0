"""A camera that rides on a body sees what a camera of the world sees that stands where it is."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np

from tests.pixels.scenes import body, scene, turned
from wmspec.sim.scene.model import Camera, Pose, Shot, Surface
from wmspec.sim.scene.model.transform import compose, inverse
from wmspec.sim.scene.render.camera import look_at
from wmspec.sim.shapes import Box, Sphere


def test_a_riding_camera_sees_what_a_standing_one_sees(renderer: Any, engine: str) -> None:
    bodies = (
        body("floor", "static", (0, 0, -0.05), Box((2.0, 2.0, 0.05)), Surface((0.7, 0.7, 0.7))),
        body("ball", "dynamic", (0, 0, 0.1), Sphere(0.1), Surface((0.8, 0.1, 0.1))),
        body("cart", "kinematic", (0, -1, 0.1), Box((0.05,) * 3), Surface((0.1, 0.3, 0.8))),
    )
    riding = Camera("eye", look_at((0, -0.9, 0.3), (0, 0, 0.1)), math.radians(50), 0.02, 20.0, body="cart")
    riding = replace(riding, pose=compose(inverse(bodies[2].pose), riding.pose))
    start = tuple(b.pose for b in bodies)
    moved = (*start[:2], Pose(np.array([0.4, -0.8, 0.2]), turned(0.35)))
    ride = renderer(engine, scene(*bodies, cameras=(riding,)), 128, 96)
    pictures = []
    for poses in (start, moved, start):
        standing = replace(riding, body=None, pose=compose(poses[2], riding.pose))
        stand = renderer(engine, scene(*bodies, cameras=(standing,)), 128, 96)
        seen, expected = ride.draw(Shot("eye", poses), depth=True), stand.draw(Shot("eye", poses), depth=True)
        assert np.abs(seen.rgb.astype(int) - expected.rgb).max() <= 1
        assert (seen.ids != expected.ids).mean() < 1e-3
        pictures.append(seen.rgb)
    assert np.array_equal(pictures[0], pictures[2])
    assert (pictures[0] != pictures[1]).mean() > 0.1
