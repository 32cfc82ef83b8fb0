"""What moves is drawn on a picture of what stands still: as if all were drawn at once, whatever was drawn before."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import wmspec
from wmspec.backends.mujoco import render
from wmspec.backends.mujoco.backdrop import MAX_BACKDROPS, BodySubset
from wmspec.backends.mujoco.render import Renderer
from wmspec.core.memoize import LRU
from wmspec.core.resources import resource
from wmspec.sim.scene.model import Pose, Scene, Shot, Surface
from wmspec.sim.scene.render.camera import project
from wmspec.sim.scene.render.window import TILE, WINDOW_MARGIN, MovingBodies, full_window
from wmspec.sim.usd import read

SIZE = 128
TASKS = {
    "trajectory_tabletop": "specs/perception/motion/trajectory.wms",
    "direction_room": "specs/perception/motion/direction.wms",
}


@pytest.fixture(scope="module", params=TASKS)
def scene(request: pytest.FixtureRequest) -> Scene:
    task = wmspec.load(resource(TASKS[request.param]), task=request.param)
    return read(task[5].stage())


def shots(scene: Scene) -> list[Shot]:
    """From every camera, as it begins and with what moves somewhere else."""
    aside = [replace(body.pose, position=body.pose.position + np.array([0.04, -0.03, 0.05])) for body in scene.bodies]
    still = [body.motion == "static" for body in scene.bodies]
    moved = [body.pose if rests else pose for body, rests, pose in zip(scene.bodies, still, aside, strict=True)]
    return [Shot(camera.name, poses) for camera in scene.cameras for poses in ([b.pose for b in scene.bodies], moved)]


def test_pictures_are_those_that_are_drawn_at_once(scene: Scene, monkeypatch: pytest.MonkeyPatch) -> None:
    """But for some pixels at edges, by rounding."""
    renderer, windows = Renderer(scene, SIZE, SIZE), []
    drawn = Renderer._layer
    monkeypatch.setattr(Renderer, "_layer", lambda *all: windows.append(all[-1]) or drawn(*all))
    frames = [renderer.draw(shot, depth=True) for shot in shots(scene)]
    assert any(0 < window.share < render.MAX_WINDOW_SHARE for window in windows)
    monkeypatch.setattr(render, "MAX_WINDOW_SHARE", -1.0)
    for shot, frame in zip(shots(scene), frames, strict=True):
        whole = renderer.draw(shot, depth=True)
        apart = np.abs(whole.rgb.astype(int) - frame.rgb).max(axis=2)
        assert (apart > 8).mean() < 0.002
        assert (whole.ids != frame.ids).mean() < 0.001
        same = whole.ids == frame.ids
        assert whole.depth is not None
        assert frame.depth is not None
        assert (np.abs(whole.depth - frame.depth)[same] > 0.002).mean() < 0.001
    renderer.close()


def test_earlier_pictures_change_no_byte(scene: Scene, monkeypatch: pytest.MonkeyPatch) -> None:
    renderer = Renderer(scene, SIZE, SIZE)
    first = [renderer.draw(shot) for shot in shots(scene)]
    monkeypatch.setattr(render, "_BACKDROPS", LRU(MAX_BACKDROPS))
    other = replace(scene, bodies=scene.bodies[::-1])  # bodies have other numbers in it, and pictures are the same
    fresh = Renderer(other, SIZE, SIZE)
    for shot, frame in reversed(list(zip(shots(scene), first, strict=True))):
        again = fresh.draw(Shot(shot.camera, shot.poses[::-1]))
        assert np.array_equal(again.ids, np.where(frame.ids < 0, -1, len(scene.bodies) - 1 - frame.ids))
        assert (again.rgb != frame.rgb).mean() < 0.001  # the order in which things are drawn decides ties
        monkeypatch.setattr(render, "_BACKDROPS", LRU(MAX_BACKDROPS))
        assert np.array_equal(renderer.draw(shot).rgb, frame.rgb)
    renderer.close(), fresh.close()


def test_recoloured_static_body_is_another_backdrop(scene: Scene) -> None:
    renderer = Renderer(scene, SIZE, SIZE)
    shot = shots(scene)[0]
    before = renderer.draw(shot)
    seen = int(np.bincount(before.ids[before.ids >= 0]).argmax())
    assert scene.bodies[seen].motion == "static"
    geoms = tuple(replace(geom, surface=Surface((0.9, 0.1, 0.9))) for geom in scene.bodies[seen].geoms)
    bodies = [replace(body, geoms=geoms) if i == seen else body for i, body in enumerate(scene.bodies)]
    renderer.repaint(replace(scene, bodies=tuple(bodies)))
    after = renderer.draw(shot)
    assert (np.abs(after.rgb.astype(int) - before.rgb).max(axis=2)[before.ids == seen] > 0).mean() > 0.9
    renderer.close()


@cache
def alone(name: str) -> tuple[Scene, Renderer]:
    """What stands still in a task, and one thing that moves, the last body."""
    scene = read(wmspec.load(resource(TASKS[name]), task=name)[5].stage())
    still = [body for body in scene.bodies if body.motion == "static"]
    moving = next(body for body in scene.bodies if body.motion != "static")
    scene = replace(scene, bodies=(*still, moving))
    return scene, Renderer(scene, SIZE, SIZE)


@settings(deadline=None, max_examples=12)
@given(st.sampled_from(sorted(TASKS)), st.floats(-0.9, 0.9), st.floats(-0.9, 0.9), st.floats(0, 0.6), st.floats(0, 3.0))
def test_nothing_outside_the_window_matters(name: str, x: float, y: float, z: float, turn: float) -> None:
    """Wherever a thing is put, the window is where pixels are not those of the place without it."""
    scene, renderer = alone(name)
    moving, eye = scene.bodies[-1].pose, scene.cameras[0]
    pose = Pose(moving.position + np.array([x, y, z]), np.array([np.cos(turn / 2), 0, np.sin(turn / 2), 0]))
    shot = Shot(eye.name, [*(body.pose for body in scene.bodies[:-1]), pose])
    renderer.draw(shot)
    region, both = renderer._still.region(eye, shot), (renderer._still, renderer._every)
    with pytest.MonkeyPatch.context() as patch:  # another near plane is another rounding of shadows
        patch.setattr(BodySubset, "nearest", lambda _, eye, shot: eye)
        without, within = (renderer._layer(cast, eye, region, shot, full_window(SIZE, SIZE)) for cast in both)
    lit = MovingBodies(scene).lit(without.ids, without.depth, eye)
    window = MovingBodies(scene).window(lit, eye, shot, (SIZE, SIZE), 2 * region.half / render.SHADOW_MAP)
    outside = np.ones((SIZE, SIZE), bool)
    outside[window.part] = False
    assert not (within.ids != without.ids)[outside].any()
    assert not (np.abs(within.rgb.astype(int) - without.rgb).max(axis=2)[outside] > 3).any()


def test_windows_begin_and_end_with_blocks(scene: Scene) -> None:
    """And hold what moves, with an edge."""
    renderer = Renderer(scene, SIZE, SIZE)
    for shot in shots(scene):
        eye = next(camera for camera in scene.cameras if camera.name == shot.camera)
        frame = renderer.draw(shot, depth=True)
        assert frame.depth is not None
        moving = MovingBodies(scene)
        window = moving.window(moving.lit(frame.ids, frame.depth, eye), eye, shot, (SIZE, SIZE), 0.006)
        assert not any(n % TILE for n in (window.left, window.right, SIZE - window.top, SIZE - window.bottom))
        numbers = [i for i, body in enumerate(scene.bodies) if body.motion != "static"]
        places, depths = project(eye, [shot.poses[i].position for i in numbers], SIZE, SIZE)
        inside = ((places > WINDOW_MARGIN) & (places < SIZE - WINDOW_MARGIN)).all(axis=1) & (depths > 0)
        for x, y in places[inside]:
            assert window.left <= x - WINDOW_MARGIN < x + WINDOW_MARGIN <= window.right
            assert window.top <= y - WINDOW_MARGIN < y + WINDOW_MARGIN <= window.bottom
    renderer.close()
