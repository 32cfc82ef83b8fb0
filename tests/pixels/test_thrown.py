"""Shapes whose shadows no camera sees are left out of MuJoCo's shadow map, and no pixel tells."""

import numpy as np
import pytest

import wmspec
from backends.mujoco.render import Renderer
from wmspec.resources import resource
from wmspec.scene.camera import seeing
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
    monkeypatch.setattr(Renderer, "_spare", lambda *_: None)
    for shot, frame in zip(shots, spared, strict=True):
        whole = renderer.draw(shot)
        assert np.array_equal(whole.rgb, frame.rgb)
        assert np.array_equal(whole.ids, frame.ids)
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
