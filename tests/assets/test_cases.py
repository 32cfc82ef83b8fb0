"""Reports of files that were read wrongly or refused, each with what is right.

`test_mesh_files`, `test_layer_metrics` and `tests.trust.test_assets` hold units, axes and compressed meshes.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import trimesh

from tests.assets.specs import checked, named, scene, spec
from tests.engines import ENGINES, installed
from tests.stage.test_layer_metrics import written
from wmspec.api import run
from wmspec.api.asset_task import asset_task
from wmspec.core.diagnostics import Diagnostic
from wmspec.sim.scene.model import Body, Scene
from wmspec.sim.shapes import Box, Sphere

mujoco = pytest.importorskip("mujoco")
INERTIAL = '<inertial><mass value="{0}"/><inertia ixx="{1}" iyy="{1}" izz="{1}" ixy="0" ixz="0" iyz="0"/></inertial>'
BOX = '<geometry><box size=".2 .2 .2"/></geometry>'
HINGE = '<joint name="j" axis="0 1 0"/><geom type="box" size=".1 .1 .1" mass="1"/>'
#: A tetrahedron.
MESH = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 2\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"
LIMIT = '<limit lower="-1" upper="1" effort="1" velocity="1"/>'


def link(name: str, kg: float = 1.0, moment: float = 0.01, look: str = "") -> str:
    shapes = f"<visual>{BOX}{look}</visual><collision>{BOX}</collision>"
    return f'<link name="{name}">{INERTIAL.format(kg, moment)}{shapes}</link>'


def object_of(tmp_path: Path, file: str, text: str = "", said: str = "") -> tuple[Scene, list[Diagnostic]]:
    """The scene of a spec with one object of a file, and what is reported about the file."""
    if text:
        (tmp_path / file).write_text(text)
    task = spec(f'object it {{ file: "{file}"  at: (0, 0, 0)  {said} }}', tmp_path)
    faults = [d for d in checked(tmp_path / "spec.wms")[1].diagnostics if d.code in ("WMS210", "WMS211")]
    return scene(task), faults


def body_of(tmp_path: Path, text: str) -> tuple[Body, Scene]:
    """The one body of an MJCF that is read exactly."""
    found, faults = object_of(tmp_path, "a.xml", text)
    assert not faults
    return next(b for b in found.bodies if b.motion == "dynamic"), found


def drive(found: Scene) -> tuple[float, float]:
    """Stiffness (N m/rad) and damping (N m s/rad) of the one joint."""
    (joint,) = found.joints
    return (joint.drive.stiffness, joint.drive.damping) if joint.drive else (0.0, 0.0)


# ---------------------------------------------------------------- MJCF


def test_two_default_sections_are_one(tmp_path: Path) -> None:
    defaults = (
        '<default><geom friction="0.3" density="500"/></default>'
        '<default><joint damping="0.7"/><default class="c"><geom type="box"/></default></default>'
    )
    body = '<joint name="j" axis="0 1 0"/><geom class="c" size=".1 .1 .1"/>'
    one, found = body_of(tmp_path, f'<mujoco>{defaults}<worldbody><body name="x">{body}</body></worldbody></mujoco>')
    assert one.mass == pytest.approx(4)
    assert one.geoms[0].friction.dynamic == pytest.approx(0.3)
    assert drive(found) == pytest.approx((0, 0.7))


def test_a_default_and_a_class_in_two_sections(tmp_path: Path) -> None:
    defaults = '<default><joint damping="1.5"/></default>'
    defaults += '<default><default class="c"><geom friction="0.2"/></default></default>'
    body = f'<worldbody><body name="x" childclass="c">{HINGE}</body></worldbody>'
    one, found = body_of(tmp_path, f"<mujoco>{defaults}{body}</mujoco>")
    assert drive(found) == pytest.approx((0, 1.5))
    assert one.geoms[0].friction.dynamic == pytest.approx(0.2)


@pytest.mark.parametrize(
    ("general", "position", "expected"),
    [
        ('gear="3"', 'kp="10"', (90, 0)),
        ('biastype="affine" gainprm="100" biasprm="0 -100 -10"', "", (100, 10)),
    ],
)
def test_defaults_of_general_actuators_are_those_of_position_actuators(
    tmp_path: Path, general: str, position: str, expected: tuple[float, float]
) -> None:
    actuator = f'<actuator><position joint="j" {position}/></actuator>'
    body = f'<worldbody><body name="x">{HINGE}</body></worldbody>'
    _, found = body_of(tmp_path, f"<mujoco><default><general {general}/></default>{body}{actuator}</mujoco>")
    assert drive(found) == pytest.approx(expected)


def test_a_primitive_is_fitted_to_its_mesh(tmp_path: Path) -> None:
    (tmp_path / "t.obj").write_text(MESH)
    text = (
        '<mujoco><asset><mesh name="m" file="t.obj"/></asset><worldbody><body name="x"><freejoint/>'
        '<inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/><geom {} mesh="m"/></body></worldbody></mujoco>'
    )
    one, _ = body_of(tmp_path, text.format(""))
    shape = one.geoms[0].shape
    assert isinstance(shape, Sphere)
    assert shape.radius == pytest.approx(0.432, abs=1e-3)
    one, _ = body_of(tmp_path, text.format('type="box"'))
    assert isinstance(one.geoms[0].shape, Box)
    np.testing.assert_allclose(one.geoms[0].shape.half_extent, (0.21698, 0.3873, 0.69132), atol=1e-4)


def test_an_included_default_applies(tmp_path: Path) -> None:
    (tmp_path / "d.xml").write_text('<mujoco><default><joint damping="2"/></default></mujoco>')
    body = f'<worldbody><body name="x">{HINGE}</body></worldbody>'
    _, found = body_of(tmp_path, f'<mujoco><include file="d.xml"/>{body}</mujoco>')
    assert drive(found) == pytest.approx((0, 2))


def test_a_range_from_0_to_0_is_no_limit(tmp_path: Path) -> None:
    body = HINGE.replace("/><geom", ' range="0 0"/><geom')
    _, found = body_of(tmp_path, f'<mujoco><worldbody><body name="x">{body}</body></worldbody></mujoco>')
    assert found.joints[0].limits is None


# ---------------------------------------------------------------- URDF


def test_a_movable_link_of_mass_0_at_the_end_is_fixed(tmp_path: Path) -> None:
    joint = '<joint name="j" type="continuous"><parent link="a"/><child link="b"/><origin xyz="0 0 1"/></joint>'
    found, (fault,) = object_of(tmp_path, "a.urdf", f'<robot name="r">{link("a")}{link("b", 0, 0)}{joint}</robot>')
    assert fault.severity == "warning"
    assert "a link of mass 0 moves: joint `j` is fixed" in fault.message
    (body,) = found.bodies
    assert body.mass == pytest.approx(1)
    assert [g.pose.position[2] for g in body.geoms] == pytest.approx([0, 1])


def test_a_frame_between_two_hinges_is_reported(tmp_path: Path) -> None:
    joints = (
        f'<joint name="j" type="revolute"><parent link="a"/><child link="b"/><origin xyz="0 0 1"/><axis xyz="0 0 1"/>'
        f'{LIMIT}</joint><joint name="k" type="revolute"><parent link="b"/><child link="c"/><axis xyz="0 1 0"/>'
        f"{LIMIT}</joint>"
    )
    text = f'<robot name="r">{link("a")}<link name="b"/>{link("c")}{joints}</robot>'
    found, (fault,) = object_of(tmp_path, "a.urdf", text)
    assert fault.severity == "warning"
    assert "a link between joints has no mass" in fault.message
    assert [j.limits for j in found.joints] == [pytest.approx((-1, 1))] * 2
    assert sum(b.mass or 0 for b in found.bodies) == pytest.approx(2, rel=1e-4)


def test_a_material_may_be_defined_after_its_use(tmp_path: Path) -> None:
    red = '<material name="red"><color rgba="1 0 0 1"/></material>'
    joint = '<joint name="j" type="fixed"><parent link="a"/><child link="b"/></joint>'
    first, second = link("a", look='<material name="red"/>'), link("b", look=red)
    text = f'<robot name="r">{first}{second}{joint}</robot>'
    found, faults = object_of(tmp_path, "a.urdf", text)
    assert not faults
    colors = [g.surface.color for b in found.bodies for g in b.geoms if g.visible]
    assert len(colors) == 2
    np.testing.assert_allclose(colors, [(1, 0, 0)] * 2, atol=1e-6)


def test_bullets_friction_is_read(tmp_path: Path) -> None:
    contact = '<contact><lateral_friction value="0.2"/></contact>'
    found, faults = object_of(
        tmp_path, "a.urdf", f'<robot name="r">{link("a").replace("<inertial>", contact + "<inertial>")}</robot>'
    )
    assert not faults
    assert named(found, "it").geoms[0].friction.dynamic == pytest.approx(0.2)


# ---------------------------------------------------------------- meshes


@pytest.mark.slow
@pytest.mark.parametrize(
    ("boxes", "density", "kg"),
    [
        ([((1, 0.1, 0.1), (0, 0, 0)), ((0.1, 0.1, 1), (0.45, 0, 0.55)), ((0.1, 0.1, 1), (-0.45, 0, 0.55))], 600, 18),
        ([((0.4, 0.2, 0.2), (0, 0, 0)), ((0.1, 0.1, 0.3), (0.1, 0, 0.25))], 1000, 19),
    ],
)
def test_shells_that_touch_have_the_mass_of_their_union(
    tmp_path: Path, boxes: list[tuple[tuple[float, ...], tuple[float, ...]]], density: float, kg: float
) -> None:
    parts = []
    for size, middle in boxes:
        parts.append(trimesh.creation.box(size))
        parts[-1].apply_translation(middle)
    trimesh.util.concatenate(parts).export(tmp_path / "a.obj")
    found, _ = object_of(tmp_path, "a.obj", said=f"collision: pieces  density: {density} kg/m^3")
    assert named(found, "it").mass == pytest.approx(kg, rel=1e-5)


# ---------------------------------------------------------------- servos

SERVO = """<mujoco><worldbody><body name="x" pos="0 0 1"><joint name="j" axis="0 1 0"/>
<geom type="box" size=".3 .02 .02" pos=".3 0 0" mass="1"/></body></worldbody>
<actuator><position name="p" joint="j" kp="200" kv="20"/></actuator></mujoco>"""
STAGE = """
def Xform "World"
{
    def Cube "x" ( prepend apiSchemas = ["PhysicsRigidBodyAPI", "PhysicsCollisionAPI", "PhysicsMassAPI"] )
    {
        double size = 2
        float physics:mass = 1
        double3 xformOp:translate = (0.3, 0, 1)
        float3 xformOp:scale = (0.3, 0.02, 0.02)
        uniform token[] xformOpOrder = ["xformOp:translate", "xformOp:scale"]
    }
    def PhysicsRevoluteJoint "j"
    {
        rel physics:body1 = </World/x>
        uniform token physics:axis = "Y"
        point3f physics:localPos0 = (0, 0, 1)
        point3f physics:localPos1 = (-1, 0, 0)
    }
    def MjcActuator "p"
    {
        rel mjc:target = </World/j>
        uniform token mjc:biasType = "affine"
        uniform double[] mjc:gainPrm = [200]
        uniform double[] mjc:biasPrm = [0, -200, -20]
    }
}
"""


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("ending", ["xml", "usda"])
def test_a_servo_holds_its_lever_as_in_mujoco(tmp_path: Path, ending: str, engine: str) -> None:
    installed(engine)
    model = mujoco.MjModel.from_xml_string(SERVO)
    data = mujoco.MjData(model)
    while data.time < 1:
        mujoco.mj_step(model, data)
    angle = data.joint("j").qpos[0]
    assert np.degrees(angle) == pytest.approx(0.84, abs=0.005)
    path = written(tmp_path / "a.usda", STAGE)
    (tmp_path / "a.xml").write_text(SERVO)
    made = run(path, engine, 1.0) if ending == "usda" else asset_task(tmp_path / "a.xml", 1.0)[0].run(engine)
    assert not made.notes
    (lever,) = (b for b in made.scene.bodies if b.motion == "dynamic")
    w, _, y, _ = made[lever.name].orientation[-1]
    assert 2 * np.arctan2(y, w) == pytest.approx(angle, rel=0.01)
