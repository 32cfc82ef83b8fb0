"""What one engine's pictures must be, by the laws of optics that they follow."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from benchmarks import memory
from tests.engines import installed
from tests.pixels.scenes import SUN, body, scene, turned
from wmspec.core.diagnostics import WmsError
from wmspec.sim.scene.model import Camera, Pose, Scene, Shot, Surface
from wmspec.sim.scene.render.camera import look_at, project
from wmspec.sim.scene.render.shadow import SUN_SHADE
from wmspec.sim.shapes import Box, Sphere

GREY = (0.8, 0.6, 0.4)


def still(what: Scene, camera: str) -> Shot:
    return Shot(camera, [one.pose for one in what.bodies])


@pytest.mark.parametrize("size", [(512, 512), (320, 200), (150, 301)], ids=str)
def test_ball_is_at_its_projected_place(engine: str, size: tuple[int, int], renderer: Any) -> None:
    at, radius = np.array([0.11, 0.07, 0.13]), 0.02
    eye = Camera("eye", look_at((0.7, -1.0, 0.6), (0.05, 0.0, 0.05)), math.radians(35), 0.05, 10.0)
    what = scene(body("ball", "dynamic", at, Sphere(radius), Surface(GREY)), cameras=(eye,))
    frame = renderer(engine, what, *size).draw(still(what, "eye"), depth=True)
    seen = frame.ids == 0
    rows, columns = np.nonzero(seen)
    (expected,), (distance,) = project(eye, at, *size)
    assert frame.rgb.shape == (size[1], size[0], 3)
    assert np.allclose([columns.mean() + 0.5, rows.mean() + 0.5], expected, atol=0.3)
    assert frame.depth[seen].min() == pytest.approx(distance - radius, abs=5e-4)
    disc = math.pi * (radius / distance * size[1] / 2 / math.tan(eye.fovy / 2)) ** 2
    assert seen.sum() == pytest.approx(disc, rel=0.05)


def ground(cameras: tuple[Camera, ...]) -> Scene:
    """A floating ball whose shadow on a floor is far from the ball."""
    floor = body("floor", "static", (0, 0, -0.1), Box((12.0, 12.0, 0.1)), Surface(GREY))
    return scene(floor, body("ball", "dynamic", (0, 0, 0.3), Sphere(0.06), Surface(GREY)), cameras=cameras)


def test_light_and_shadow_have_the_strength_of_the_recipe(engine: str, renderer: Any) -> None:
    eye = Camera("eye", look_at((0, -1.2, 1.2), (0, 0, 0)), math.radians(40), 0.05, 10.0)
    what = ground((eye,))
    frame = renderer(engine, what, 256, 256).draw(still(what, "eye"))
    shadow = np.array([0, 0, 0.3]) - SUN * 0.3 / SUN[2]
    (inside, outside), _ = project(eye, [shadow, shadow * [-1, -1, 0]], 256, 256)
    light = what.light.ambient - what.light.diffuse * SUN[2]
    shade = what.light.ambient - what.light.diffuse * SUN[2] * (1 - SUN_SHADE)
    assert np.allclose(frame.rgb[int(inside[1]), int(inside[0])], 255 * shade * np.array(GREY), atol=2)
    assert np.allclose(frame.rgb[int(outside[1]), int(outside[0])], 255 * light * np.array(GREY), atol=2)


@pytest.mark.parametrize("height", [0.3, 1.2, 3.0])
def test_nothing_shades_itself(engine: str, height: float, renderer: Any) -> None:
    """All of the floor is either fully lit or in the ball's shadow, of which we know the area."""
    eye = Camera("eye", look_at((0, -1.2, height), (0, 0, 0)), math.radians(50), 0.05, 10.0)
    what = ground((eye,))
    frame = renderer(engine, what, 256, 256).draw(still(what, "eye"))
    light = 255 * (what.light.ambient - what.light.diffuse * SUN[2]) * np.array(GREY)
    floor = frame.rgb[frame.ids == 0]
    dark = np.abs(floor - light).max(axis=1) > 4
    per_pixel = (2 * math.tan(eye.fovy / 2) * np.linalg.norm(eye.pose.position) / 256) ** 2
    slant = height / np.linalg.norm(eye.pose.position)
    most = math.pi * 0.06**2 / -SUN[2] * slant / per_pixel
    assert dark.sum() < 1.6 * most + 0.02 * len(floor) * (height < 1)


def test_shadows_touch_what_casts_them(engine: str, renderer: Any) -> None:
    """Beside a standing box, at its foot and away from the sun, the floor is dark."""
    eye = Camera("eye", look_at((0.5, 0.9, 0.9), (0, 0, 0)), math.radians(25), 0.05, 10.0)
    floor = body("floor", "static", (0, 0, -0.1), Box((3.0, 3.0, 0.1)), Surface(GREY))
    box = body("box", "dynamic", (0, 0, 0.05), Box((0.05,) * 3), Surface((0.2, 0.2, 0.8)))
    what = scene(floor, box, cameras=(eye,))
    frame = renderer(engine, what, 512, 512).draw(still(what, "eye"))
    light = 255 * (what.light.ambient - what.light.diffuse * SUN[2]) * GREY[0]
    for beside in ([0.01, 0.055, 0.0], [0.055, 0.01, 0.0]):
        ((x, y),), _ = project(eye, beside, 512, 512)
        assert frame.ids[int(y), int(x)] == 0
        assert frame.rgb[int(y), int(x), 0] < 0.85 * light


def test_every_body_casts_its_whole_shadow(engine: str, renderer: Any) -> None:
    """Balls on a ring, at the ends of the shadow map whichever way it is turned: the rim of each shadow is dark."""
    eye = Camera("eye", look_at((0, 0, 3.0), (0, 0, 0)), math.radians(50), 0.05, 10.0)
    floor = body("floor", "static", (0, 0, -0.1), Box((12.0, 12.0, 0.1)), Surface(GREY))
    ring = [0.9 * np.array([math.cos(a), math.sin(a), 0]) for a in np.arange(8) * math.pi / 4]
    balls = [body(f"ball{i}", "dynamic", (x, y, 0.3), Sphere(0.08), Surface(GREY)) for i, (x, y, _) in enumerate(ring)]
    what = scene(floor, *balls, cameras=(eye,))
    frame = renderer(engine, what, 384, 384).draw(still(what, "eye"))
    light = 255 * (what.light.ambient - what.light.diffuse * SUN[2]) * GREY[0]
    for at in ring:
        for rim in 0.065 * np.array([[0, 0, 0], [1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0]]):
            ((x, y),), _ = project(eye, at + rim - SUN * 0.3 / SUN[2] + [0, 0, 0.3], 384, 384)
            if frame.ids[int(y), int(x)] == 0:
                assert frame.rgb[int(y), int(x), 0] < 0.85 * light


def test_same_shot_same_bytes(engine: str, table: Scene, renderer: Any) -> None:
    one, other = renderer(engine, table, 128, 128), renderer(engine, table, 128, 128, fresh=True)
    first = one.draw(still(table, "front"), depth=True)
    one.draw(still(table, "top"))
    for again in (one, other):
        frame = again.draw(still(table, "front"), depth=True)
        assert np.array_equal(first.rgb, frame.rgb)
        assert np.array_equal(first.ids, frame.ids)
        assert np.array_equal(first.depth, frame.depth)


def test_moving_a_body_equals_building_it_there(engine: str, table: Scene, renderer: Any) -> None:
    poses = [one.pose for one in table.bodies]
    poses[3] = Pose(np.array([0.02, 0.21, 0.09]), turned(1.1))
    there = replace(table, bodies=tuple(replace(b, pose=p) for b, p in zip(table.bodies, poses, strict=True)))
    moved = renderer(engine, table, 128, 128).draw(Shot("oblique", poses))
    built = renderer(engine, there, 128, 128).draw(Shot("oblique", poses))
    assert np.array_equal(moved.rgb, built.rgb)
    assert np.array_equal(moved.ids, built.ids)


LINUX = pytest.mark.skipif(not Path("/proc/self/statm").exists(), reason="needs Linux to measure memory")


@LINUX
@pytest.mark.parametrize(("count", "most"), [(40, 4), pytest.param(5000, 30, marks=pytest.mark.slow)])
def test_drawing_does_not_leak(engine: str, count: int, most: float) -> None:
    """A leak shows in every measurement; memory that something else in this process takes does not."""
    installed(engine)
    assert any(memory.frames(engine, count) < most for _ in range(3))


@LINUX
@pytest.mark.slow
def test_rebuilding_does_not_leak(engine: str) -> None:
    installed(engine)
    assert memory.rebuilds(engine, 500) < 30


def test_mistakes_are_explained(engine: str, table: Scene, renderer: Any) -> None:
    one = renderer(engine, table, 128, 128)
    with pytest.raises(WmsError, match=r"no camera `behind`.*front"):
        one.draw(still(table, "behind"))
    with pytest.raises(WmsError, match="1 poses, expected one for each of 8"):
        one.draw(Shot("front", [table.bodies[0].pose]))
    lost = scene(body("a", "static", (0, 0, 0), Sphere(0.1), Surface(texture="lost.png")), cameras=table.cameras)
    with pytest.raises(WmsError, match=r"lost\.png"):
        renderer(engine, lost, 64, 64)


@pytest.mark.parametrize("shaders", ["trivial", pytest.param("minimal", marks=pytest.mark.slow)])
def test_bundled_shaders_of_sapien_still_work(shaders: str, table: Scene, renderer: Any) -> None:
    """Others than the trivial ones are compiled for ten seconds."""
    sapien = pytest.importorskip("sapien")
    renderer("sapien", table, 128, 128).draw(still(table, "front"))
    before = sapien.render.get_camera_shader_dir()
    sapien.render.set_camera_shader_dir(shaders)
    world = sapien.Scene([sapien.render.RenderSystem()])
    eye = world.add_camera("own", 16, 16, 1.0, 0.1, 10.0)
    world.update_render()
    eye.take_picture()
    assert eye.get_picture("Color").shape == (16, 16, 4)
    sapien.render.set_camera_shader_dir(before)
