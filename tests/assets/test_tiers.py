"""Features of files: read exactly, or approximated with one warning a kind, or refused; `strict` refuses all."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.assets.specs import checked, named, scene, spec
from wmspec.core.diagnostics import Diagnostic
from wmspec.sim.scene.model import Scene

INERTIAL = '<inertial><mass value="{kg}"/><inertia ixx="{i}" iyy="{i}" izz="{i}" ixy="0" ixz="0" iyz="0"/></inertial>'
BOX = '<geometry><box size=".2 .2 .2"/></geometry>'


def link(name: str, kg: float | None = 1.0, i: float = 0.01, shape: str = BOX, more: str = "") -> str:
    """A link of URDF; without `kg` it has no `inertial`, without `shape` no geometry."""
    mass = "" if kg is None else INERTIAL.format(kg=kg, i=i)
    form = f"<visual>{shape}</visual><collision>{shape}</collision>" if shape else ""
    return f'<link name="{name}">{mass}{form}{more}</link>\n'


def joint(name: str, parent: str, child: str, kind: str = "fixed", more: str = "") -> str:
    ends = f'<parent link="{parent}"/><child link="{child}"/>'
    return f'<joint name="{name}" type="{kind}">{ends}<origin xyz="0 0 1"/><axis xyz="0 0 1"/>{more}</joint>'


def written(tmp_path: Path, *parts: str) -> None:
    (tmp_path / "a.urdf").write_text(f'<robot name="r">{"".join(parts)}</robot>')


def warnings(tmp_path: Path, said: str = "", file: str = "a.urdf") -> list[Diagnostic]:
    path = tmp_path / "spec.wms"
    path.write_text(f'task t : custom {{ object it {{ file: "{file}"  at: (0, 0, 0)  {said} }} }}')
    return [d for d in checked(path)[1].diagnostics if d.code in ("WMS210", "WMS211")]


def made(tmp_path: Path, said: str = "", file: str = "a.urdf") -> Scene:
    return scene(spec(f'object it {{ file: "{file}"  at: (0, 0, 0)  {said} }}', tmp_path))


def mjcf(tmp_path: Path, body: str, more: str = "", before: str = "") -> None:
    (tmp_path / "a.xml").write_text(f"<mujoco>{before}<worldbody>{body}</worldbody>{more}</mujoco>")


# ---------------------------------------------------------------- links without mass


def test_a_root_of_mass_0_is_fixed(tmp_path: Path) -> None:
    written(tmp_path, link("a", 0, 0), link("b"), joint("j", "a", "b", "continuous"))
    (warning,) = warnings(tmp_path)
    assert "it has a mass of 0: it is fixed" in warning.message
    assert named(made(tmp_path), "it").motion == "static"


def test_a_fixed_link_of_mass_0_is_a_part_of_its_holder(tmp_path: Path) -> None:
    written(tmp_path, link("a"), link("b", 0, 0), joint("j", "a", "b"))
    assert not warnings(tmp_path)
    (body,) = made(tmp_path).bodies
    assert sorted(g.pose.position[2] for g in body.geoms) == pytest.approx([0, 1])
    assert body.mass == pytest.approx(1)


def test_a_link_without_mass_that_is_only_drawn_is_a_part_of_its_holder(tmp_path: Path) -> None:
    plate = f'<link name="b"><visual>{BOX}</visual></link>'
    written(tmp_path, link("a"), plate, joint("j", "a", "b"))
    assert not warnings(tmp_path)
    (body,) = made(tmp_path).bodies
    assert sorted(g.collides for g in body.geoms) == [False, True]
    assert body.mass == pytest.approx(1)


def test_a_frame_between_two_joints_is_a_light_link(tmp_path: Path) -> None:
    turn = '<limit lower="-1" upper="1"/>'
    ends = joint("j", "a", "b", "revolute", turn), joint("k", "b", "c", "revolute", turn)
    written(tmp_path, link("a"), link("b", None, shape=""), link("c"), *ends)
    (warning,) = warnings(tmp_path)
    assert "a link between joints has no mass: it moves with 1e-05 kg" in warning.message
    found = made(tmp_path)
    assert len(found.joints) == 2
    assert named(found, "it_b").mass == pytest.approx(1e-5)


def test_a_root_frame_that_several_links_are_fixed_to(tmp_path: Path) -> None:
    root = link("root", None, shape="")
    written(tmp_path, root, link("a"), link("b"), joint("j", "root", "a"), joint("k", "root", "b"))
    assert "it is joined to its neighbours with" in warnings(tmp_path)[0].message
    found = made(tmp_path)
    assert sum(body.mass for body in found.bodies) == pytest.approx(2, rel=1e-4)


def test_empty_bodies_beside_the_base_do_not_matter(tmp_path: Path) -> None:
    arm = '<body name="arm" pos="0 0 .2"><joint/><geom size=".1"/></body>'
    for goal in ("", '<body name="goal" pos="1 1 0"><site size=".1"/></body>'):
        mjcf(tmp_path, f'{goal}<body name="stand" pos="0 1 0"><geom size=".1"/>{arm}</body>')
        found = made(tmp_path, file="a.xml")
        assert {body.name: body.motion for body in found.bodies} == {"it": "static", "it_arm": "dynamic"}


def test_a_frame_with_nothing_behind_it_does_not_matter(tmp_path: Path) -> None:
    written(tmp_path, link("a"), link("tip", None, shape=""), joint("j", "a", "tip", "continuous"))
    assert not warnings(tmp_path)
    assert not made(tmp_path).joints


@pytest.mark.parametrize(("first", "second", "reported"), [(0.0, 0.1, True), (0.1, 0.0, False)])
def test_moments_of_a_link_without_mass_are_left_out(
    tmp_path: Path, first: float, second: float, reported: bool
) -> None:
    """Those of a root, which is fixed, bear on nothing."""
    written(tmp_path, link("root", 0, first), link("b"), link("c", 0, second), joint("j", "root", "b"),
            joint("k", "b", "c"))  # fmt: skip
    messages = [d.message for d in warnings(tmp_path)]
    expected = "`link c`: a link of mass 0 with moments of inertia is not supported: they are left out"
    assert any(expected in m for m in messages) == reported
    assert any("moments of inertia" in m for m in messages) == reported


# ---------------------------------------------------------------- inertias


@pytest.mark.parametrize(
    ("kg", "i", "message"),
    [(0.025, 1.0, "its inertia is"), (1.0, 0.0, "its mass is 1 kg and its inertia 0")],
)
def test_an_impossible_inertia_is_that_of_the_shapes(tmp_path: Path, kg: float, i: float, message: str) -> None:
    written(tmp_path, link("a", kg, i))
    (warning,) = warnings(tmp_path)
    assert message in warning.message
    assert "that of its shapes is used" in warning.message
    (body,) = made(tmp_path).bodies
    assert body.inertia is not None
    np.testing.assert_allclose(body.inertia.moments, kg * 0.04 / 6, rtol=1e-5)


def test_inertia_of_the_file_is_kept(tmp_path: Path) -> None:
    written(tmp_path, link("a", 0.025, 1.0))
    (body,) = made(tmp_path, "inertia: file").bodies
    assert body.inertia is not None
    np.testing.assert_allclose(body.inertia.moments, 1, rtol=1e-5)


def test_moments_of_no_body_are_those_of_the_shapes(tmp_path: Path) -> None:
    text = link("a").replace('izz="0.01"', 'izz="0.05"')
    written(tmp_path, text)
    assert "the largest is 150 % above the others' sum" in warnings(tmp_path)[0].message


def test_an_inertia_that_is_only_large_is_reported_and_used(tmp_path: Path) -> None:
    written(tmp_path, link("a", 1, 0.5))
    (warning,) = warnings(tmp_path)
    assert "it is used" in warning.message
    (body,) = made(tmp_path).bodies
    assert body.inertia is not None
    np.testing.assert_allclose(body.inertia.moments, 0.5, rtol=1e-5)


# ---------------------------------------------------------------- grouping, strict


def test_one_warning_a_kind_with_its_count_and_strict_refuses_it(tmp_path: Path) -> None:
    stiff = '<contact><stiffness value="3"/></contact>'
    written(tmp_path, link("a", more=stiff), link("b", more=stiff), link("c", more=stiff),
            joint("j", "a", "b"), joint("k", "b", "c"))  # fmt: skip
    (warning,) = warnings(tmp_path)
    assert warning.severity == "warning"
    assert warning.message.endswith("(here and 2 more)")
    (error,) = warnings(tmp_path, "strict: true")
    assert error.severity == "error"
    (wrong,) = (d for d in checked(tmp_path / "spec.wms")[1].diagnostics if d.severity == "error")
    assert wrong == error


def test_all_errors_of_a_file_at_once(tmp_path: Path) -> None:
    mesh = '<collision><geometry><mesh filename="{}.stl"/></geometry></collision>'
    written(tmp_path, link("a", more=mesh.format("x")), link("b", more=mesh.format("y")), link("c", -1, 0.1))
    messages = [d.message for d in warnings(tmp_path) if d.severity == "error"]
    assert len(messages) == 2
    assert "there is no mesh `x.stl`" in messages[0]
    assert "(here and 1 more)" in messages[0]
    assert "a mass of -1 kg" in messages[1]


@pytest.mark.parametrize("said", ["strict: 1", "inertia: shapes"])
def test_settings_of_an_asset_are_checked(tmp_path: Path, said: str) -> None:
    written(tmp_path, link("a"))
    warnings(tmp_path, said)
    assert [d.code for d in checked(tmp_path / "spec.wms")[1].diagnostics if d.severity == "error"] == ["WMS302"]


# ---------------------------------------------------------------- URDF


def test_a_visual_mesh_that_is_missing_is_left_out(tmp_path: Path) -> None:
    shape = '<visual><geometry><mesh filename="none.stl"/></geometry></visual>'
    written(tmp_path, link("a", more=shape))
    (warning,) = warnings(tmp_path)
    assert "left out of pictures" in warning.message
    assert len(named(made(tmp_path), "it").geoms) == 1


def test_a_flat_mesh_does_not_collide(tmp_path: Path) -> None:
    (tmp_path / "flat.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nf 1 2 3\nf 2 4 3\n")
    shape = '<geometry><mesh filename="flat.obj"/></geometry>'
    written(tmp_path, link("a", more=f"<visual>{shape}</visual><collision>{shape}</collision>"))
    (warning,) = warnings(tmp_path)
    assert "a flat mesh cannot collide: it is drawn only" in warning.message
    assert [g.collides for g in named(made(tmp_path), "it").geoms] == [True, False]


@pytest.mark.parametrize(
    ("limit", "limits", "kind"),
    [
        ('<limit lower="0.3" upper="0.3"/>', None, "fixed"),
        ('<limit lower="1" upper="-1"/>', None, "hinge"),
        ('<limit effort="3" velocity="2"/>', None, "hinge"),
        ('<limit lower="-1e16" upper="1e16"/>', None, "hinge"),
        ('<limit lower="-.5" upper=".5"/>', (-0.5, 0.5), "hinge"),
    ],
)
def test_limits_as_in_bullet(tmp_path: Path, limit: str, limits: Any, kind: str) -> None:
    written(tmp_path, link("a"), link("b"), joint("j", "a", "b", "revolute", limit))
    (held,) = made(tmp_path).joints
    assert held.kind == kind
    assert held.limits == (None if limits is None else pytest.approx(limits))


def test_ambiguous_names_get_a_suffix(tmp_path: Path) -> None:
    written(tmp_path, link("a"), link("mass"), joint("a", "a", "mass", "continuous"))
    assert "a spec adds `_link` or `_joint`" in warnings(tmp_path)[0].message
    found = made(tmp_path)
    assert named(found, "it_mass_link").mass == pytest.approx(1)
    assert [j.name for j in found.joints] == ["it_a_joint"]


def test_xml_reads_like_simple_parsers(tmp_path: Path) -> None:
    text = f'<!-- made by hand -->\n<?xml version="1.0"?>\n<robot name="r">{link("a")}</robot>\0'
    (tmp_path / "a.urdf").write_text(text)
    assert not warnings(tmp_path)


# ---------------------------------------------------------------- MJCF

BODY = '<body name="x"><freejoint/><geom type="box" size=".1 .1 .1"/></body>'


def test_an_include_is_read_below_the_folder_of_the_spec_alone(tmp_path: Path) -> None:
    inner = tmp_path / "inner"
    inner.mkdir()
    (tmp_path / "outside.xml").write_text(f"<mujoco><worldbody>{BODY}</worldbody></mujoco>")
    (inner / "a.xml").write_text('<mujoco><include file="../outside.xml"/><worldbody/></mujoco>')
    assert "there is no file `../outside.xml` below the spec's folder" in warnings(inner, file="a.xml")[0].message
    (inner / "b.xml").write_text(f"<mujoco><worldbody>{BODY}</worldbody></mujoco>")
    (inner / "a.xml").write_text('<mujoco><include file="b.xml"/></mujoco>')
    assert not warnings(inner, file="a.xml")


def test_an_error_in_an_included_file_has_its_line(tmp_path: Path) -> None:
    (tmp_path / "b.xml").write_text(
        '<mujoco>\n<worldbody>\n<body name="x">\n<geom\nsize="-1"/></body></worldbody></mujoco>'
    )
    (tmp_path / "a.xml").write_text('<mujoco><include file="b.xml"/></mujoco>')
    (error,) = warnings(tmp_path, file="a.xml")
    assert "b.xml:4: `geom`: MuJoCo refuses it: size 0 must be positive" in error.message


@pytest.mark.parametrize("outside", ['<mesh name="m" file="/etc/hostname.stl"/>', '<mesh name="m" file="../m.stl"/>'])
def test_muJoCo_opens_no_file_itself(tmp_path: Path, outside: str) -> None:
    mjcf(tmp_path, BODY, before=f"<default><mesh file='/etc/passwd'/></default><asset>{outside}</asset>")
    (error,) = (d for d in warnings(tmp_path, file="a.xml") if d.severity == "error")
    assert "below the spec's folder" in error.message


def test_replication_is_bounded_before_it_is_made(tmp_path: Path) -> None:
    nested = f'<replicate count="99999"><replicate count="99999">{BODY}</replicate></replicate>'
    mjcf(tmp_path, nested)
    (error,) = warnings(tmp_path, file="a.xml")
    assert "has more than 500 bodies" in error.message


def test_bodies_without_joints_and_mass_stand_on_the_world(tmp_path: Path) -> None:
    """As the feet of two arms on a table do, whose geoms do not collide."""
    arm = '<body name="{0}" pos="{1} 0 0"><geom size=".1" mass="0" contype="0" conaffinity="0"/>{2}</body>'
    lever = '<body name="{0}_arm"><joint name="{0}_turn"/><geom size=".1" pos=".3 0 0"/></body>'
    bodies = "".join(arm.format(name, x, lever.format(name)) for name, x in (("left", -1), ("right", 1)))
    mjcf(tmp_path, f'<body name="table"><geom type="box" size="2 2 .1" pos="0 0 -1" mass="0"/></body>{bodies}')
    found = made(tmp_path, file="a.xml")
    assert [j.name for j in found.joints] == ["it_left_turn", "it_right_turn"]
    assert named(found, "it_left").motion == "static"


def test_several_joints_of_a_body_are_a_chain(tmp_path: Path) -> None:
    slides = (
        '<joint name="x" type="slide" axis="1 0 0"/><joint name="z" type="slide"/><joint name="turn" axis="0 1 0"/>'
    )
    mjcf(tmp_path, f'<body name="b">{slides}<geom size=".1" mass="2"/></body>')
    found = made(tmp_path, file="a.xml")
    assert [j.kind for j in found.joints] == ["slider", "slider", "hinge"]
    assert [j.name for j in found.joints] == ["it_x", "it_z", "it_turn"]
    assert named(found, found.joints[-1].second).mass == pytest.approx(2)


@pytest.mark.parametrize(
    ("first", "second", "passes"),
    [("1 1", "1 1", False), ("1 0", "1 0", True), ("1 0", "0 1", False), ("2 2", "1 1", True)],
)
def test_contact_bits_decide_which_links_pass_each_other(tmp_path: Path, first: str, second: str, passes: bool) -> None:
    bodies = ""
    for i, bits in enumerate((first, second)):
        contype, conaffinity = bits.split()
        geom = f'<geom size=".1" contype="{contype}" conaffinity="{conaffinity}"/>'
        bodies += f'<body name="b{i}" pos="{i} 0 0"><freejoint/>{geom}</body>'
    mjcf(tmp_path, bodies)
    assert bool(made(tmp_path, file="a.xml").filtered) == passes


def test_motors_planes_and_tendons_are_reported_once_a_kind(tmp_path: Path) -> None:
    plane, held = '<geom type="plane" size="1 1 1"/>', '<joint name="j"/>'
    body = f'{plane}<body name="b">{held}<geom size=".1" mass="1"/></body>'
    more = (
        '<actuator><motor joint="j"/>\n<motor joint="j"/></actuator>'
        '<tendon><fixed name="t"><joint joint="j" coef="1"/></fixed></tendon>'
    )
    mjcf(tmp_path, body, more)
    messages = " ".join(d.message for d in warnings(tmp_path, file="a.xml"))
    assert "planes are not supported: left out" in messages
    assert "no position or velocity actuator needs a control: left out (here and 1 more)" in messages
    assert "`fixed` tendons are not supported: left out" in messages


@pytest.mark.parametrize(
    ("floor", "friction"),
    [("", 0.0), ('<geom type="plane" size="1 1 1" condim="1"/>', 0.0), ('<geom type="plane" size="1 1 1"/>', 0.9)],
)
def test_geoms_of_condim_1_have_friction_on_others(tmp_path: Path, floor: str, friction: float) -> None:
    """MuJoCo takes the larger `condim` of two geoms."""
    mjcf(tmp_path, f'{floor}<body name="x"><freejoint/><geom size=".1" condim="1" friction=".9"/></body>')
    (body,) = made(tmp_path, file="a.xml").bodies
    assert body.geoms[0].friction.dynamic == pytest.approx(friction)
    messages = [d.message for d in warnings(tmp_path, file="a.xml")]
    assert any("(`condim` 1) are not supported: they have friction" in m for m in messages) == (friction > 0)


@pytest.mark.parametrize(("limits", "reported"), [("30 70", True), ("-70 -30", True), ("0 70", False), ("-9 9", False)])
def test_a_start_outside_the_limits_is_reported(tmp_path: Path, limits: str, reported: bool) -> None:
    held = f'<joint name="j" limited="true" range="{limits}"/>'
    mjcf(tmp_path, f'<body name="x">{held}<geom type="box" size=".1 .1 .1"/></body>')
    messages = [d.message for d in warnings(tmp_path, file="a.xml")]
    what = "a start outside the limits of a joint is not supported: it starts at the nearer limit"
    assert [what in m for m in messages] == [True] * reported


def test_keyframes_and_constraints_are_reported_by_name(tmp_path: Path) -> None:
    body = '<body name="b"><joint name="j"/><geom size=".1"/></body>'
    more = (
        '<keyframe><key name="home" qpos=".5"/></keyframe>'
        '<equality><joint name="stop" joint1="j"/><connect name="pin" body1="b" anchor="0 0 0"/></equality>'
    )
    mjcf(tmp_path, body, more)
    messages = [d.message for d in warnings(tmp_path, file="a.xml")]
    assert ["`key home`" in m for m in messages].count(True) == 1
    assert any("keyframes are not supported: the start is that without them" in m for m in messages)
    assert any("`joint stop`: `joint` constraints are not supported: left out" in m for m in messages)
    assert any("`connect pin`: `connect` constraints are not supported: left out" in m for m in messages)
    assert len(warnings(tmp_path, "strict: true", "a.xml")) == 3
    mjcf(tmp_path, body, '<keyframe><key name="late" time="1"/></keyframe>')
    assert not warnings(tmp_path, file="a.xml")


@pytest.mark.parametrize(
    ("gravity", "reported"), [("0 0 0", True), ("0 0 -1.6", True), ("0 0 -9.8", False), ("1 0 -9.81", True)]
)
def test_another_gravity_is_reported(tmp_path: Path, gravity: str, reported: bool) -> None:
    mjcf(tmp_path, BODY, before=f'<option gravity="{gravity}"/>')
    assert bool(warnings(tmp_path, file="a.xml")) == reported


def test_properties_of_a_free_joint_are_reported(tmp_path: Path) -> None:
    free = '<joint name="root" type="free" damping="1" armature="2"/>'
    mjcf(tmp_path, f'<body name="x">{free}<geom type="box" size=".1 .1 .1"/></body>')
    messages = [d.message for d in warnings(tmp_path, file="a.xml")]
    assert len(messages) == 2
    assert "`damping` of a free joint is not supported: left out" in messages[0]
    assert "`armature` of a free joint is not supported: left out" in messages[1]


@pytest.mark.parametrize(("gear", "most"), [("2", 3.0), ("-2", 3.0), ("0.25", 2.5)])
def test_the_force_on_a_joint_limits_its_actuator(tmp_path: Path, gear: str, most: float) -> None:
    held = '<joint name="j" actuatorfrcrange="-3 4"/>'
    servo = f'<actuator><position joint="j" kp="9" gear="{gear}" forcerange="-10 10"/></actuator>'
    mjcf(tmp_path, f'<body name="x">{held}<geom type="box" size=".1 .1 .1"/></body>', servo)
    (joint,) = made(tmp_path, file="a.xml").joints
    assert joint.drive is not None
    assert joint.drive.max_force == pytest.approx(most)


def test_a_force_limit_beside_a_damper_limits_both(tmp_path: Path) -> None:
    servo = '<actuator><position joint="j" kp="9" kv="1" forcerange="-10 10"/></actuator>'
    mjcf(tmp_path, '<body name="x"><joint name="j" damping="2"/><geom type="box" size=".1 .1 .1"/></body>', servo)
    (warning,) = warnings(tmp_path, file="a.xml")
    assert "the force limit of an actuator beside a spring or damper" in warning.message
    assert "it limits their sum" in warning.message
    (joint,) = made(tmp_path, file="a.xml").joints
    assert joint.drive is not None
    found = (joint.drive.stiffness, joint.drive.damping, joint.drive.max_force)
    assert found == pytest.approx((9, 3, 10))


def test_a_world_without_contacts_has_shapes_that_do_not_collide(tmp_path: Path) -> None:
    mjcf(tmp_path, BODY, before='<option><flag contact="disable"/></option>')
    assert not warnings(tmp_path, file="a.xml")
    assert [g.collides for g in named(made(tmp_path, file="a.xml"), "it").geoms] == [False]
