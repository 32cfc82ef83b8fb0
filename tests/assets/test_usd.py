"""What wmspec makes of an asset in USD, against what its reader of stages makes of the same file."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from pxr import Usd

from tests.assets.specs import HERE, here, named, scene, spec, tensor
from tests.engines import ENGINES, installed
from wmspec.compile.design.design import Design
from wmspec.compile.stage.episode import document
from wmspec.compile.stage.layers import compose as composed
from wmspec.sim.scene.model import Body, Scene
from wmspec.sim.scene.model.bounds import world_box
from wmspec.sim.scene.model.transform import apply, compose, rotation
from wmspec.sim.usd import read

OBJECT = 'object balance {{ file: "balance.usda"  at: (0, 0, 0)  {0} }}'
#: The bodies of tests/assets/balance.usda by what they are in a spec.
BODIES = {"beam": "balance_beam", "left": "balance_left", "right": "balance_right"}


def folder(tmp_path: Path) -> Path:
    (tmp_path / "balance.usda").write_bytes((HERE / "balance.usda").read_bytes())
    return tmp_path


def both(tmp_path: Path) -> tuple[Scene, Scene]:
    """The scene of a spec that places the asset where its file does, and the scene in the file."""
    file = folder(tmp_path) / "balance.usda"
    return scene(spec(OBJECT.format(""), tmp_path)), read(Usd.Stage.Open(str(file)))


@pytest.mark.parametrize("name", BODIES)
def test_bodies_are_those_of_the_stage(tmp_path: Path, name: str) -> None:
    found, expected = (named(s, n) for s, n in zip(both(tmp_path), (BODIES[name], name), strict=True))
    np.testing.assert_allclose(found.pose.position, expected.pose.position, atol=1e-6)
    np.testing.assert_allclose(rotation(found.pose.orientation), rotation(expected.pose.orientation), atol=1e-6)
    assert found.inertia is not None
    assert expected.inertia is not None
    assert found.inertia.mass == pytest.approx(expected.inertia.mass, rel=1e-6)
    np.testing.assert_allclose(found.inertia.center, expected.inertia.center, atol=1e-6)
    np.testing.assert_allclose(tensor(found), tensor(expected), rtol=1e-5, atol=1e-9)
    np.testing.assert_allclose(corners(found), corners(expected), atol=1e-6)


def corners(body: Body) -> np.ndarray[tuple[int, int], np.dtype[np.float64]]:
    return np.asarray(world_box(body.geoms, body.pose))


@pytest.mark.parametrize("name", ["pivot", "string", "hook"])
def test_joints_are_those_of_the_stage(tmp_path: Path, name: str) -> None:
    """The same frames in the world, but for which of its two ends comes first, which turns its coordinate round."""
    found, expected = both(tmp_path)
    one = next(j for j in found.joints if j.name == f"balance_{name}")
    other = next(j for j in expected.joints if j.name == name)
    assert one.kind == other.kind
    turned = one.second != BODIES.get(other.second, "balance")
    if other.limits is not None:
        assert one.limits == pytest.approx(other.limits, abs=1e-6)
    if other.drive is not None:
        assert one.drive is not None
        assert (one.drive.stiffness, one.drive.damping) == pytest.approx((other.drive.stiffness, other.drive.damping))
        assert one.drive.target == pytest.approx(other.drive.target)
    here_, there = place(found, one.second, one.second_frame), place(expected, other.second, other.second_frame)
    beyond = place(expected, other.first, other.first_frame)
    np.testing.assert_allclose(here_, beyond if turned else there, atol=1e-6)


def place(of: Scene, name: str | None, frame: object) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
    body = named(of, name) if name else None
    return np.asarray(compose(body.pose, frame).position if body else frame.position)  # type: ignore[arg-type, attr-defined]


@pytest.mark.parametrize("engine", ENGINES)
def test_it_moves_as_the_stage_does(tmp_path: Path, engine: str) -> None:
    from dataclasses import replace

    installed(engine)
    found, expected = (replace(s, duration=1.0, rate=60) for s in both(tmp_path))
    one, other = (installed(engine).execute(s) for s in (found, expected))
    for name in ("left", "right"):  # the frame of the beam is where it turns
        ours = BODIES[name]
        i, j = one.bodies.index(ours), other.bodies.index(name)
        np.testing.assert_allclose(one.position[-1, i], other.position[-1, j], atol=2e-4)
        assert np.linalg.norm(one.position[-1, i] - one.position[0, i]) > 0.01


def test_a_urdf_that_became_a_stage_becomes_an_asset_again(tmp_path: Path) -> None:
    """What wmspec writes of a URDF, without its episode and camera, is read back as the same bodies."""
    task = spec('object arm { file: "arm.urdf"  at: (0, 0, 0)  part turn { start: 0.4 rad } }', here(tmp_path))
    stage = composed(document(task, Design(task)[0]))
    for path in ("/World/Episode", "/World/Cameras", "/World/Lights", "/World/Objects/arm_shoulder/shape_0"):
        stage.GetPrimAtPath(path).SetActive(False)
    stage.Export(str(tmp_path / "again.usda"))
    again = scene(spec('object again { file: "again.usda"  at: (0, 0, 0) }', tmp_path))
    first = scene(task)
    for ours, name in (("again", "arm"), ("again_arm_shoulder", "arm_shoulder"), ("again_arm_tip", "arm_tip")):
        a, b = named(again, ours), named(first, name)
        np.testing.assert_allclose(corners(a), corners(replace_geoms(b)), atol=1e-5)
        assert a.inertia is not None
        assert b.inertia is not None
        np.testing.assert_allclose(apply(a.pose, a.inertia.center), apply(b.pose, b.inertia.center), atol=1e-5)


def replace_geoms(body: Body) -> Body:
    return replace(body, geoms=tuple(g for g in body.geoms if type(g.shape).__name__ != "Mesh"))
