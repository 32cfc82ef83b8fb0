"""What no camera sees is left out by MuJoCo, things, shadows and the background, and no pixel tells.

Nor does the ground on which all stands go into the sun's map, which a few pixels at the edges of shadows may tell.
"""

from dataclasses import replace

import numpy as np
import pytest

import wmspec
from wmspec.backends.mujoco import render
from wmspec.backends.mujoco.render import Renderer
from wmspec.core.resources import resource
from wmspec.sim.scene.model import Body, Scene, Shot
from wmspec.sim.scene.render.boxes import view_edges
from wmspec.sim.scene.render.camera import look_at, world_camera
from wmspec.sim.scene.render.shadow_culling import ShadowCulling, VisibleSet
from wmspec.sim.usd import read

SIZE = 96


@pytest.fixture(scope="module")
def scene() -> Scene:
    task = wmspec.load(resource("specs/perception/motion/trajectory.wms"), task="trajectory_tabletop")
    return read(task[5].stage())


@pytest.fixture(autouse=True)
def all_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """Pictures are drawn whole, not on backdrops."""
    monkeypatch.setattr(render, "MAX_WINDOW_SHARE", -1.0)


def test_no_pixel_differs(scene: Scene, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(ShadowCulling, "_ground", lambda self, bottom, *_: np.zeros(len(bottom), bool))
    renderer = Renderer(scene, SIZE, SIZE)
    shots = [Shot(camera.name, tuple(body.pose for body in scene.bodies)) for camera in scene.cameras]
    spared = [renderer.draw(shot) for shot in shots]
    left = renderer._view.ngeom
    every = np.ones(renderer._model.ngeom, bool)
    monkeypatch.setattr(ShadowCulling, "sight", lambda *_: VisibleSet(every, every))
    for shot, frame in zip(shots, spared, strict=True):
        whole = renderer.draw(shot)
        assert np.array_equal(whole.rgb, frame.rgb)
        assert np.array_equal(whole.ids, frame.ids)
    assert left < renderer._view.ngeom
    renderer.close()


def test_visible_geoms_cast_visible_shadows(scene: Scene) -> None:
    thrown = ShadowCulling(scene)
    shown = [body.name for body in scene.bodies for geom in body.geoms if geom.visible]
    counts = {}
    for one in scene.cameras:
        shot = Shot(one.name, tuple(body.pose for body in scene.bodies))
        camera = world_camera(scene, shot)
        seen = thrown.sight(camera, view_edges(camera, 1.0), shot, 0.006).seen
        assert {"east", "west"} <= {name for name, one in zip(shown, seen, strict=True) if one}
        counts[one.name] = int(seen.sum())
    assert counts["here_top"] < len(shown) / 4  # it sees the table and no more


@pytest.mark.parametrize("up", [0.0, 0.6, 1.2])
def test_no_pixel_reveals_the_background(scene: Scene, up: float) -> None:
    """Down into the room, along its walls, and over them, where there is nothing."""
    eye = look_at(np.array([0.0, -1.5, 1.5]), np.array([0.0, 0.0, 1.5 * up]))
    scene = replace(scene, cameras=tuple(replace(camera, pose=eye, body=None) for camera in scene.cameras))
    spared, whole = Renderer(scene, SIZE, SIZE), Renderer(scene, SIZE, SIZE)
    whole._open = True
    shot = Shot(scene.cameras[0].name, tuple(body.pose for body in scene.bodies))
    for _ in range(2):  # what was open once is open for good
        one, other = spared.draw(shot), whole.draw(shot)
        assert np.array_equal(one.rgb, other.rgb)
        assert np.array_equal(one.ids, other.ids)
    assert spared._open >= (one.ids < 0).any()
    spared.close(), whole.close()


def test_ground_without_shadow_changes_hardly_a_pixel(scene: Scene, monkeypatch: pytest.MonkeyPatch) -> None:
    """By less than anybody sees; an object that is missing in the map changes hundreds of pixels by more than 100."""
    renderer = Renderer(scene, SIZE, SIZE)
    shots = [Shot(camera.name, tuple(body.pose for body in scene.bodies)) for camera in scene.cameras]
    without = [renderer.draw(shot).rgb.astype(int) for shot in shots]
    monkeypatch.setattr(ShadowCulling, "_ground", lambda self, bottom, *_: np.zeros(len(bottom), bool))
    apart = [np.abs(renderer.draw(shot).rgb - rgb).max(axis=2) for shot, rgb in zip(shots, without, strict=True)]
    assert max(int((one > 24).sum()) for one in apart) <= 2
    monkeypatch.setattr(ShadowCulling, "_ground", lambda self, bottom, *_: np.ones(len(bottom), bool))
    apart = [np.abs(renderer.draw(shot).rgb - rgb).max(axis=2) for shot, rgb in zip(shots, without, strict=True)]
    assert max(int((one > 24).sum()) for one in apart) > 20
    renderer.close()


def test_ground_is_a_box_under_everything(scene: Scene) -> None:
    shown = np.array([body.name for body in scene.bodies for geom in body.geoms if geom.visible])
    ground = np.isin(shown, ["here_floor", "here_ground"])
    sunk = replace(scene, bodies=tuple(_sunk(body) if body.name == "east" else body for body in scene.bodies))
    found = []
    for what in (scene, sunk):
        shot = Shot("here_front", tuple(body.pose for body in what.bodies))
        camera = world_camera(what, shot)
        sight = ShadowCulling(what).sight(camera, view_edges(camera, 1.0), shot, 0.006)
        assert sight.seen[ground].any()
        assert not (sight.seen & ~sight.casts)[~ground].any()
        found.append((sight.seen & ~sight.casts).any())
    assert found == [True, False]


def _sunk(body: Body) -> Body:
    """Behind the table, where the floor shades it."""
    return replace(body, pose=replace(body.pose, position=body.pose.position - np.array([0.0, -0.5, 0.85])))
