"""What wmspec makes of an MJCF, against what MuJoCo makes of it."""

from __future__ import annotations

from math import radians
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.assets.specs import HERE, named, scene, spec, tensor
from wmspec.sim.scene.model import Scene
from wmspec.sim.scene.model.transform import rotation
from wmspec.sim.shapes.capsule import Capsule

mujoco = pytest.importorskip("mujoco")
LINKS = ("boom", "trolley", "hook", "plate")


def crane(tmp_path: Path, slew: float = 0.0, run: float = 0.0) -> tuple[Scene, Any, Any]:
    """The crane with two of its joints at these places (deg, m): our scene, and MuJoCo's model and data."""
    (tmp_path / "crane.xml").write_bytes((HERE / "crane.xml").read_bytes())
    parts = f"part slew {{ start: {slew} deg }}  part run {{ start: {run} m }}"
    found = scene(spec(f'object crane {{ file: "crane.xml"  at: (0, 0, 0)  {parts} }}', tmp_path))
    model = mujoco.MjModel.from_xml_path(str(tmp_path / "crane.xml"))
    data = mujoco.MjData(model)
    data.joint("slew").qpos[0], data.joint("run").qpos[0] = radians(slew), run
    mujoco.mj_forward(model, data)
    return found, model, data


@pytest.mark.parametrize(("slew", "run"), [(0.0, 0.0), (40.0, -0.15), (-90.0, 0.2)])
def test_bodies_are_placed_as_in_mujoco(tmp_path: Path, slew: float, run: float) -> None:
    found, _, data = crane(tmp_path, slew, run)
    for name in LINKS:
        ours, theirs = named(found, f"crane_{name}").pose, data.body(name)
        np.testing.assert_allclose(ours.position, theirs.xpos, atol=1e-9)
        np.testing.assert_allclose(rotation(ours.orientation), theirs.xmat.reshape(3, 3), atol=1e-9)


@pytest.mark.parametrize("name", LINKS)
def test_masses_are_those_of_mujoco(tmp_path: Path, name: str) -> None:
    found, model, data = crane(tmp_path)
    body, theirs = named(found, f"crane_{name}"), model.body(name)
    assert body.inertia is not None
    assert body.inertia.mass == pytest.approx(theirs.mass[0], rel=1e-6)
    own, axes = rotation(body.pose.orientation), data.body(name).ximat.reshape(3, 3)
    middle = body.pose.position + own @ body.inertia.center
    np.testing.assert_allclose(middle, data.body(name).xipos, atol=1e-7)
    expected = axes @ np.diag(theirs.inertia) @ axes.T
    np.testing.assert_allclose(own @ tensor(body) @ own.T, expected, rtol=1e-5, atol=1e-8)


def test_joints_are_those_of_mujoco(tmp_path: Path) -> None:
    found, model, data = crane(tmp_path)
    joints = {j.name.removeprefix("crane_"): j for j in found.joints}
    for name, kind in (("slew", "hinge"), ("run", "slider"), ("swivel", "ball")):
        ours, theirs = joints[name], data.joint(name)
        assert ours.kind == kind
        first = named(found, ours.first or "")
        at = first.pose.position + rotation(first.pose.orientation) @ ours.first_frame.position
        np.testing.assert_allclose(at, theirs.xanchor, atol=1e-7)
        if kind != "ball":
            axis = rotation(first.pose.orientation) @ rotation(ours.first_frame.orientation)[:, 0]
            np.testing.assert_allclose(axis, theirs.xaxis, atol=1e-6)
            assert ours.limits == pytest.approx(model.joint(name).range, rel=1e-6)
    spring, drive = joints["slew"].drive, joints["run"].drive
    assert spring is not None
    assert drive is not None
    assert (spring.stiffness, spring.damping, spring.target) == pytest.approx((3, 0.3, radians(10)), rel=1e-6)
    assert (drive.stiffness, drive.damping, drive.target) == pytest.approx((50, 4.3, 0), rel=1e-6)
    assert joints["plate_fixed"].kind == "fixed"


def test_shapes_are_those_of_mujoco(tmp_path: Path) -> None:
    found, model, _ = crane(tmp_path)
    boom = named(found, "crane_boom").geoms
    assert [g.collides for g in boom] == [True, True, False]
    assert [type(g.shape).__name__ for g in boom] == ["Capsule", "Box", "Sphere"]
    assert isinstance(boom[0].shape, Capsule)
    assert boom[0].shape.height == pytest.approx(2 * model.geom_size[1][1], rel=1e-6)
    assert boom[0].friction.dynamic == pytest.approx(0.7)
    assert named(found, "crane").motion == "static"


HINGE = '<joint name="j" axis="0 1 0"/><geom type="box" size=".1 .1 .1" mass="1"/>'
#: What sets a value in one place and is used in another: sections of defaults, and the body `x`.
INHERITING = {
    "two sections": (
        (
            '<default><geom friction="0.3" density="500"/></default>'
            '<default><joint damping="0.7"/><default class="c"><geom type="box"/></default></default>'
        ),
        '<joint name="j" axis="0 1 0"/><geom class="c" size=".1 .1 .1"/>',
        "",
    ),
    "root in one, class in another": (
        (
            '<default><joint damping="1.5"/></default>'
            '<default><default class="c"><geom friction="0.2"/></default></default>'
        ),
        '<joint class="c" name="j" axis="0 1 0"/><geom class="c" type="box" size=".1 .1 .1" mass="1"/>',
        "",
    ),
    "a class before the second section": (
        '<default><default class="c"><joint armature="0"/></default></default><default><joint damping="2"/></default>',
        '<joint class="c" name="j" axis="0 1 0"/><geom type="box" size=".1 .1 .1" mass="1"/>',
        "",
    ),
    "gear of general": ('<default><general gear="3"/></default>', HINGE, '<position joint="j" kp="10"/>'),
    "gain and bias of general": (
        '<default><general biastype="affine" gainprm="100" biasprm="0 -100 -10"/></default>',
        HINGE,
        '<position joint="j"/>',
    ),
    "kv of general, kp of the actuator": (
        '<default><general biasprm="0 -100 -10"/></default>',
        HINGE,
        '<position joint="j" kp="7" gear="-2"/>',
    ),
    "velocity": ('<default><velocity kv="4"/></default>', HINGE, '<position joint="j"/>'),
    "motor after position": (
        '<default><position kp="9" kv="2"/><motor gear="2"/></default>',
        HINGE,
        '<position joint="j"/>',
    ),
    "main by name": (
        '<default class="main"><geom friction="0.4"/></default>',
        '<joint name="j" axis="0 1 0"/><geom class="main" type="box" size=".1 .1 .1" mass="1"/>',
        "",
    ),
    "a range without room": ("", HINGE.replace("/><geom", ' range="0 0"/><geom'), ""),
    "a range the wrong way round": ("", HINGE.replace("/><geom", ' range="1 -1"/><geom'), ""),
}


@pytest.mark.parametrize("case", INHERITING)
def test_inherited_defaults_are_those_of_mujoco(case: str, tmp_path: Path) -> None:
    defaults, body, actuator = INHERITING[case]
    text = f'{defaults}<worldbody><body name="x">{body}</body></worldbody><actuator>{actuator}</actuator>'
    (tmp_path / "a.xml").write_text(f'<mujoco><compiler angle="radian"/>{text}</mujoco>')
    model = mujoco.MjModel.from_xml_path(str(tmp_path / "a.xml"))
    found = scene(spec('object it { file: "a.xml"  at: (0, 0, 1 m)  fixed: false }', tmp_path))
    (joint,) = found.joints
    (one,) = (b for b in found.bodies if b.inertia is not None or b.motion == "dynamic")
    (geom,) = one.geoms
    assert geom.friction.dynamic == pytest.approx(model.geom_friction[0, 0])
    mass = one.inertia.mass if one.inertia is not None else None
    assert mass == pytest.approx(model.body("x").mass[0], rel=1e-6)
    assert (joint.limits is not None) == bool(model.joint("j").limited[0])
    stiffness = damping = 0.0
    if joint.drive is not None:
        stiffness, damping = joint.drive.stiffness, joint.drive.damping
    gear = model.actuator_gear[0, 0] if actuator else 0.0
    bias = model.actuator_biasprm[0] if actuator else np.zeros(3)
    assert stiffness == pytest.approx(-(gear**2) * bias[1])
    assert damping == pytest.approx(model.dof_damping[0] - gear**2 * bias[2])
