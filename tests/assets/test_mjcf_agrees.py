"""Random MJCF with defaults, classes, frames, replication and fitted meshes, against MuJoCo's own model."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from tests.assets.specs import named, scene, spec, tensor
from wmspec.sim.scene.model.transform import rotation

mujoco = pytest.importorskip("mujoco")

MESH = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 2\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"
NUMBER = st.integers(-10, 10).map(lambda n: n / 10)
POSITIVE = st.integers(1, 9).map(lambda n: n / 10)
PLACE = st.tuples(NUMBER, NUMBER, NUMBER).map(lambda p: f'pos="{p[0]} {p[1]} {p[2]}"')
TURN = st.sampled_from(
    ["", 'euler="30 -40 70"', 'quat="1 .2 -.3 .4"', 'axisangle="1 1 0 50"', 'xyaxes="0 1 0 -1 0 .5"', 'zaxis="1 2 3"']
)
CLASS = st.sampled_from(["", 'class="a"', 'class="b"'])
SIZED = {"sphere": 1, "capsule": 2, "cylinder": 2, "box": 3}


@st.composite
def geoms(draw: Any) -> str:
    """A geom with its mass, possibly a primitive fitted to a mesh."""
    kind = draw(st.sampled_from([*SIZED, "mesh", "fitted", "fromto"]))
    place, weight = (
        f"{draw(PLACE)} {draw(TURN)} {draw(CLASS)}",
        draw(st.sampled_from(["", 'mass="0.7"', 'density="500"'])),
    )
    if kind == "mesh":
        return f'<geom type="mesh" mesh="m" {place} {weight}/>'
    if kind == "fitted":
        return f'<geom type="{draw(st.sampled_from(list(SIZED)))}" mesh="m" {place} {weight}/>'
    if kind == "fromto":
        return (
            f'<geom type="capsule" fromto="0 0 0 {draw(POSITIVE)} {draw(NUMBER)} 0" size="{draw(POSITIVE)}" {weight}/>'
        )
    size = " ".join(str(draw(POSITIVE)) for _ in range(SIZED[kind]))
    return f'<geom type="{kind}" size="{size}" {place} {weight}/>'


@st.composite
def joints(draw: Any, name: str) -> str:
    """No joint, or a hinge or slide with limits, springs and dampers, some from its class; some with rotors."""
    kind = draw(st.sampled_from(["", "hinge", "slide"]))
    if not kind:
        return ""
    more = draw(st.sampled_from(["", 'range="-.5 .7"', 'range="-.2 .3" limited="true" ref=".1"', 'damping="3"']))
    spring = draw(st.sampled_from(["", 'stiffness="5" springref=".2"']))
    rotor = draw(st.sampled_from(["", 'armature=".1"']))
    axis = draw(st.sampled_from(["0 0 1", "1 1 0", "0 -2 1"]))
    return f'<joint name="{name}" type="{kind}" axis="{axis}" {draw(PLACE)} {draw(CLASS)} {more} {spring} {rotor}/>'


@st.composite
def models(draw: Any) -> str:
    """A model of up to four bodies, in frames and replicated."""
    radian = draw(st.sampled_from(["radian", "degree"]))
    defaults = (
        f'<default><geom friction="{draw(POSITIVE)}" density="{draw(st.integers(200, 900))}"/>'
        f'<default class="a"><geom friction="{draw(POSITIVE)}"/><joint damping="{draw(POSITIVE)}"/>'
        f'<default class="b"><joint stiffness="{draw(POSITIVE)}" range="-.3 .4"/><geom density="300"/></default>'
        "</default></default>"
    )
    child = draw(st.sampled_from(["", 'childclass="a"', 'childclass="b"']))
    bodies = ""
    for i in reversed(range(draw(st.integers(1, 3)))):
        made = "".join(draw(geoms()) for _ in range(draw(st.integers(1, 2))))
        held = draw(joints(f"j{i}"))
        inner = f'<body name="b{i}" {draw(PLACE)} {draw(TURN)} {child}>{held}{made}{bodies}</body>'
        wrap = draw(st.sampled_from(["{}", '<frame pos=".1 .2 .3" euler="10 20 30">{}</frame>']))
        bodies = wrap.format(inner)
    if draw(st.booleans()):
        bodies = f'<replicate count="2" offset="3 0 0" euler="0 0 20">{bodies}</replicate>'
    mesh = '<asset><mesh name="m" file="m.obj" scale=".3 .3 .3"/></asset>'
    anchor = '<geom type="box" size=".1 .1 .1" pos="0 0 -9"/>'
    return f'<mujoco><compiler angle="{radian}"/>{defaults}{mesh}<worldbody>{anchor}{bodies}</worldbody></mujoco>'


@settings(deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture], max_examples=20)
@given(text=models())
def test_masses_frames_limits_and_springs_are_those_of_mujoco(text: str, tmp_path: Path) -> None:
    (tmp_path / "m.obj").write_text(MESH)
    (tmp_path / "a.xml").write_text(text)
    model = mujoco.MjModel.from_xml_path(str(tmp_path / "a.xml"))
    data = mujoco.MjData(model)
    starts = {}
    for j in range(model.njnt):  # wmspec starts within the limits
        at = int(model.jnt_qposadr[j])
        if model.jnt_limited[j]:
            data.qpos[at] = np.clip(data.qpos[at], *model.jnt_range[j])
        starts[model.joint(j).name] = data.qpos[at]
    mujoco.mj_forward(model, data)
    found = scene(spec('object it { file: "a.xml"  at: (0, 0, 0) }', tmp_path))
    for i in range(1, model.nbody):
        body = named(found, f"it_{model.body(i).name}")
        np.testing.assert_allclose(body.pose.position, data.xpos[i], atol=1e-6)
        own = rotation(body.pose.orientation)
        np.testing.assert_allclose(own, data.xmat[i].reshape(3, 3), atol=1e-6)
        if body.inertia is None:
            continue
        assert body.inertia.mass == pytest.approx(model.body_mass[i], rel=1e-5)
        np.testing.assert_allclose(body.pose.position + own @ body.inertia.center, data.xipos[i], atol=1e-5)
        turn = data.ximat[i].reshape(3, 3)
        expected = turn @ np.diag(model.body_inertia[i]) @ turn.T
        np.testing.assert_allclose(own @ tensor(body) @ own.T, expected, rtol=1e-4, atol=1e-5 * np.trace(expected))
        _same_geoms(body, model, data, i)
    mine = {j.name: j for j in found.joints}
    for j in range(model.njnt):
        joint, dof, at = mine[f"it_{model.joint(j).name}"], int(model.jnt_dofadr[j]), int(model.jnt_qposadr[j])
        ref = model.qpos0[at]
        if model.jnt_limited[j]:
            assert joint.limits == pytest.approx(model.jnt_range[j] - ref, rel=1e-5, abs=1e-6)
        else:
            assert joint.limits is None
        stiffness, damping = (joint.drive.stiffness, joint.drive.damping) if joint.drive else (0.0, 0.0)
        assert (stiffness, damping) == pytest.approx((model.jnt_stiffness[j], model.dof_damping[dof]), rel=1e-5)
        assert joint.armature == pytest.approx(model.dof_armature[dof])
        if stiffness and joint.drive:
            assert joint.drive.target == pytest.approx(model.qpos_spring[at] - ref, rel=1e-5, abs=1e-6)


def _same_geoms(body: Any, model: Any, data: Any, i: int) -> None:
    """The collision shapes reach as far along the axes of the world as MuJoCo's, and rub as they do."""
    first, count = int(model.body_geomadr[i]), int(model.body_geomnum[i])
    geoms = [g for g in body.geoms if g.collides]
    assert len(geoms) == count
    for geom, g in zip(geoms, range(first, first + count), strict=True):
        assert geom.friction.dynamic == pytest.approx(model.geom_friction[g, 0], rel=1e-5)
        turn = rotation(body.pose.orientation) @ rotation(geom.pose.orientation)
        at = body.pose.position + rotation(body.pose.orientation) @ geom.pose.position
        low, high = at + geom.shape.bounds(turn)
        kinds = mujoco.mjtGeom
        if model.geom_type[g] == kinds.mjGEOM_MESH:
            start, number = int(model.mesh_vertadr[model.geom_dataid[g]]), int(model.mesh_vertnum[model.geom_dataid[g]])
            points = model.mesh_vert[start : start + number] @ data.geom_xmat[g].reshape(3, 3).T + data.geom_xpos[g]
            np.testing.assert_allclose((low, high), (points.min(axis=0), points.max(axis=0)), atol=1e-5)
        else:
            np.testing.assert_allclose((low + high) / 2, data.geom_xpos[g], atol=1e-5)
            assert sorted(geom.shape.half_extent) == pytest.approx(sorted(_half(model, g)), rel=1e-5)


def _half(model: Any, g: int) -> list[float]:
    """Half extents of a primitive along its axes."""
    a, b, c = (float(x) for x in model.geom_size[g])
    kinds = mujoco.mjtGeom
    match int(model.geom_type[g]):
        case kinds.mjGEOM_SPHERE:
            return [a, a, a]
        case kinds.mjGEOM_CAPSULE:
            return [a, a, a + b]
        case kinds.mjGEOM_CYLINDER:
            return [a, a, b]
    return [a, b, c]
