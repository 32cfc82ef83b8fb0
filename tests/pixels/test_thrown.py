"""What no camera sees is left out by MuJoCo, things, shadows and the background, and no pixel tells."""

from dataclasses import replace

import numpy as np
import pytest

import wmspec
from backends.mujoco.render import Renderer
from wmspec.resources import resource
from wmspec.scene.camera import look_at, seeing
from wmspec.scene.model import Scene, Shot
from wmspec.scene.thrown import Thrown
from wmspec.usd import read

SIZE = 96


@pytest.fixture(scope="module")
def scene() -> Scene:
    task = wmspec.load(resource("specs/perception/motion/trajectory.wms"), task="trajectory_tabletop")
    return read(task[5].stage())


def test_no_pixel_tells(scene: Scene, monkeypatch: pytest.MonkeyPatch) -> None:
    renderer = Renderer(scene, SIZE, SIZE)
    shots = [Shot(camera.name, tuple(body.pose for body in scene.bodies)) for camera in scene.cameras]
    spared = [renderer.draw(shot) for shot in shots]
    left = renderer._view.ngeom
    monkeypatch.setattr(Thrown, "seen", lambda *_: np.ones(renderer._model.ngeom, bool))
    for shot, frame in zip(shots, spared, strict=True):
        whole = renderer.draw(shot)
        assert np.array_equal(whole.rgb, frame.rgb)
        assert np.array_equal(whole.ids, frame.ids)
    assert left < renderer._view.ngeom
    renderer.close()


def test_what_is_seen_throws_a_shadow_that_may_be_seen(scene: Scene) -> None:
    thrown = Thrown(scene, 1.0)
    shown = [body.name for body in scene.bodies for geom in body.geoms if geom.visible]
    counts = {}
    for camera in scene.cameras:
        shot = Shot(camera.name, tuple(body.pose for body in scene.bodies))
        seen = thrown.seen(seeing(scene, shot), shot, 0.006)
        assert {"east", "west"} <= {name for name, one in zip(shown, seen, strict=True) if one}
        counts[camera.name] = int(seen.sum())
    assert counts["here_top"] < len(shown) / 4  # it sees the table and no more


@pytest.mark.parametrize("up", [0.0, 0.6, 1.2])
def test_no_pixel_tells_of_the_background(scene: Scene, up: float) -> None:
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
