"""Visual contents, and what can be executed approximately, have a stand-in with a note; `--strict` refuses them."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from numpy.testing import assert_allclose
from pxr import Usd

import wmspec
from tests.engines import ENGINES, installed
from tests.stage.stages import assert_same, stage
from wmspec.cli import main
from wmspec.core.diagnostics import StageError
from wmspec.sim.scene.joints.articulations import loop_closures, loop_joints, trees
from wmspec.sim.scene.model import Scene
from wmspec.sim.usd import read

SHAPE = """
def Xform "thing" (prepend apiSchemas = ["PhysicsRigidBodyAPI", "PhysicsMassAPI"]) {{
    float physics:mass = 2
    double3 xformOp:translate = (0, 0, 1)
    uniform token[] xformOpOrder = ["xformOp:translate"]
    {inside}
}}
{more}
"""
BALL = 'def Sphere "ball" (prepend apiSchemas = ["PhysicsCollisionAPI"]) { double radius = 0.1 %s }'
SQUASHED = """double3 xformOp:scale = (1, 2, 3)
    uniform token[] xformOpOrder = ["xformOp:scale"]"""
GROUP = 'def Xform "group" (prepend apiSchemas = ["PhysicsCollisionAPI"]) { def Sphere "ball" { double radius = 0.1 } }'

CASES = {
    "a lamp": (BALL % "", 'def SphereLight "lamp" {}', "left out of pictures"),
    "curves": (BALL % "", 'def BasisCurves "hair" {}', "left out of pictures"),
    "a camera": (BALL % "", 'def Camera "top" { token projection = "orthographic" }', "left out"),
    "a material": (BALL % "rel material:binding = </nowhere>", "", "left out"),
    "an ellipsoid": (BALL % SQUASHED, "", "less volume"),
    "a group": (GROUP, "", "the geometries below it collide"),
    "no collider": ("", "", "distributed as in a ball of 0.1 m"),
    "two suns": (BALL % "", 'def DistantLight "a" {}\ndef DistantLight "b" {}', "the first one is used"),
    "two scenes": (BALL % "", 'def PhysicsScene "a" {}\ndef PhysicsScene "b" {}', "which has the same gravity"),
}


def made(name: str) -> Usd.Stage:
    inside, more, _ = CASES[name]
    return stage(SHAPE.format(inside=inside, more=more))


@pytest.mark.parametrize("name", CASES)
def test_substitute_is_reported_once_and_refused_when_strict(name: str) -> None:
    (note,) = read(made(name), strict=False).notes
    assert note.severity == "warning"
    assert note.place is not None
    assert note.help
    assert CASES[name][2] in note.message
    with pytest.raises(StageError):
        read(made(name))


def test_plain_stage_is_read_alike_when_strict() -> None:
    plain = stage(SHAPE.format(inside=BALL % "", more=""))
    assert_same(read(plain, strict=False), read(plain))


def test_ellipsoid_has_its_mass() -> None:
    (body,) = read(made("an ellipsoid"), strict=False).bodies
    assert body.inertia is not None
    assert_allclose(body.inertia.moments, 2 / 5 * 0.01 * np.array([13, 10, 5]), rtol=0.02)


LINKED = """
def Xform "a" (prepend apiSchemas = ["PhysicsRigidBodyAPI", "PhysicsMassAPI"]) {
    float physics:mass = 1
    float3 physics:diagonalInertia = (0.1, 0.1, 0.1)
    double3 xformOp:translate = (0, 0, -1)
    uniform token[] xformOpOrder = ["xformOp:translate"]
}
"""
JOINT = """
def PhysicsJoint "joint" (prepend apiSchemas = [%s]) {
    rel physics:body1 = </World/a>
    point3f physics:localPos1 = (0, 0, 1)
    %s
}
"""


def locked(*ways: str) -> str:
    apis = ", ".join(f'"PhysicsLimitAPI:{way}"' for way in ways)
    numbers = "\n".join(f"float limit:{way}:physics:low = 1\nfloat limit:{way}:physics:high = -1" for way in ways)
    return JOINT % (apis, numbers)


UNIVERSAL = LINKED + locked("transX", "transY", "transZ", "rotZ")


def test_a_joint_of_two_axes_is_a_chain_of_two_joints() -> None:
    scene = read(stage(UNIVERSAL), strict=False)
    assert [joint.kind for joint in scene.joints] == ["hinge", "hinge"]
    _, between = scene.bodies
    assert between.inertia is not None
    assert between.inertia.mass == pytest.approx(1e-5)
    assert "chain of 2 joints" in scene.notes[0].message


@pytest.mark.parametrize("engine", ENGINES)
def test_a_pendulum_on_a_universal_joint_swings_as_one_on_a_hinge(engine: str) -> None:
    installed(engine)
    pushed = UNIVERSAL.replace("(0, 0, -1)", "(0.19866933079506122, 0, -0.9800665778412416)", 1)
    pushed = pushed.replace('["xformOp:translate"]', '["xformOp:translate", "xformOp:rotateY"]', 1)
    pushed = pushed.replace("double3 xformOp", "float xformOp:rotateY = -11.459155902616466\n    double3 xformOp", 1)
    run = wmspec.run(stage(pushed), engine, 1.0)
    assert run.movable == ("a",)
    x = run["a"].position[:, 0]
    half = float(np.interp(0, -x[:240], run.time[:240]))  # a quarter of 2 pi sqrt(1.1/9.81), and 0.25 % for 0.2 rad
    assert half == pytest.approx(np.pi / 2 * np.sqrt(1.1 / 9.81) * 1.0025, rel=2e-3)


APART = (
    LINKED
    + """
def PhysicsRevoluteJoint "joint" {
    rel physics:body1 = </World/a>
    uniform token physics:axis = "Y"
    point3f physics:localPos0 = (0, 0, 0.5)
    point3f physics:localPos1 = (0, 0, 1)
    float physics:lowerLimit = 10
    float physics:upperLimit = 20
}
"""
)


def test_separated_or_out_of_limit_start_is_moved_to_its_joint() -> None:
    scene = read(stage(APART), strict=False)
    ten = np.radians(10)
    assert_allclose(scene.bodies[0].pose.position, [-np.sin(ten), 0, 0.5 - np.cos(ten)], atol=1e-9)
    assert "500 mm and 0.175 rad" in scene.notes[0].message
    assert trees(scene)[0][0].start == pytest.approx(ten)


def ring(kinds: tuple[str, ...], limit: str = "") -> Scene:
    """Bodies at the corners of a square, each jointed to the next."""
    places = [(0, 0, 1), (1, 0, 1), (1, 0, 2), (0, 0, 2)]
    text = ""
    for i, (x, y, z) in enumerate(places):
        text += LINKED.replace('"a"', f'"b{i}"').replace("(0, 0, -1)", f"({x}, {y}, {z})")
    for i, kind in enumerate(kinds):
        other = (i + 1) % 4
        local = tuple(p - q for p, q in zip(places[i], places[other], strict=True))
        text += f"""def Physics{kind}Joint "j{i}" {{
            rel physics:body0 = </World/b{i}>
            rel physics:body1 = </World/b{other}>
            uniform token physics:axis = "Y"
            point3f physics:localPos1 = {local}
            {limit}
        }}
        """
    return read(stage(text), strict=False)


def test_a_loop_is_closed_by_points_where_a_joint_is_no_more_than_that() -> None:
    scene = ring(("Revolute", "Prismatic", "Revolute", "Revolute"))
    (tie,) = loop_closures(scene)
    assert scene.joints[tie.joint].kind == "hinge"
    assert len(tie.above) == 2


def test_else_a_body_is_split_and_weighs_the_same() -> None:
    limits = "float physics:lowerLimit = -45\nfloat physics:upperLimit = 45"
    scene = ring(("Revolute",) * 4, limits)
    assert len(scene.bodies) == 5
    assert sum(body.inertia.mass for body in scene.bodies if body.inertia) == pytest.approx(4)
    (number,) = loop_joints(scene)
    assert scene.joints[number].kind == "fixed"


@pytest.mark.parametrize("engine", ENGINES)
def test_a_loop_falls_as_one(engine: str) -> None:
    from dataclasses import replace

    for limit in ("", "float physics:lowerLimit = -45\nfloat physics:upperLimit = 45"):
        scene = replace(ring(("Revolute",) * 4, limit), duration=0.5)
        trace = installed(engine).execute(scene)
        fallen = trace.position[-1, :4] - trace.position[0, :4]
        assert_allclose(fallen, [(0, 0, -9.81 / 8)] * 4, atol=1e-4)


def test_run_reports_it_on_the_terminal_in_json_and_in_the_trace(tmp_path: Path) -> None:
    installed("mujoco")
    path, trace = tmp_path / "stage.usda", tmp_path / "trace.npz"
    made("a lamp").Export(str(path))
    command = ["run", str(path), "-b", "mujoco", "--for", "100ms"]
    reported = CliRunner().invoke(main, [*command, "-o", str(trace)])
    assert reported.exit_code == 0
    assert "warning: /World/lamp: only a DistantLight" in reported.output
    with np.load(trace) as arrays:
        assert "left out of pictures" in str(arrays["notes"][0])
    (row,) = json.loads(CliRunner().invoke(main, [*command, "--json"]).stdout)
    assert row["notes"][0]["prim"] == "/World/lamp"
    assert CliRunner().invoke(main, [*command, "--strict"]).exit_code == 2


RAIL = """
def PhysicsPrismaticJoint "rail" (prepend apiSchemas = ["PhysicsDriveAPI:linear"]) {
    rel physics:body1 = </World/thing>
    point3f physics:localPos0 = (0, 0, 1)
    float drive:linear:physics:stiffness = 100
    float drive:linear:physics:damping = 5
    uniform token drive:linear:physics:type = "acceleration"
}
"""


def test_a_drive_by_acceleration_is_a_force_for_what_it_moves() -> None:
    text = SHAPE.format(inside=BALL % "", more=RAIL)
    driven = read(stage(text), strict=False)
    drive = driven.joints[0].drive
    assert drive is not None
    assert (drive.stiffness, drive.damping) == pytest.approx((200, 10))
    assert any("a force drive for its initial load" in str(note) for note in driven.notes)
    with pytest.raises(StageError, match="by acceleration"):
        read(stage(text))


def test_impossible_moments_of_inertia_are_clipped_and_reported() -> None:
    text = SHAPE.format(inside=BALL % "", more="").replace(
        "float physics:mass = 2", "float physics:mass = 2\n    float3 physics:diagonalInertia = (0.1, 0.1, 0.3)"
    )
    cut = read(stage(text), strict=False)
    inertia = cut.bodies[0].inertia
    assert inertia is not None
    assert_allclose(inertia.moments, [0.1, 0.1, 0.2], rtol=1e-6)
    assert "50 % above" in str(cut.notes[0])
    with pytest.raises(StageError, match="diagonalInertia"):
        read(stage(text))


def turned(moment: float, more: str = "") -> Usd.Stage:
    """A ball of 2 kg and 0.1 m with these moments of inertia (kg m²)."""
    text = SHAPE.format(inside=BALL % "", more="")
    mass = f"float physics:mass = 2\n float3 physics:diagonalInertia = ({moment}, {moment}, {moment})\n {more}"
    return stage(text.replace("float physics:mass = 2", mass))


def test_an_inertia_that_no_body_of_that_size_can_have_is_that_of_its_shapes() -> None:
    found = read(turned(100.0), strict=False)
    (body,), (note,) = found.bodies, found.notes
    assert body.inertia is not None
    assert_allclose(body.inertia.moments, 0.4 * 2 * 0.01, rtol=1e-6)
    assert "its inertia is" in note.message
    assert "that of its shapes is used" in note.message
    with pytest.raises(StageError, match="times the largest"):
        read(turned(100.0))


def test_an_inertia_that_is_only_large_is_reported_and_used() -> None:
    found = read(turned(0.5), strict=False)
    (body,), (note,) = found.bodies, found.notes
    assert body.inertia is not None
    assert_allclose(body.inertia.moments, 0.5, rtol=1e-6)
    assert "it is used" in note.message
    assert read(turned(0.5)).bodies[0].inertia is not None


def test_a_stage_may_keep_an_impossible_inertia() -> None:
    kept = read(turned(100.0, 'uniform token wms:inertia = "authored"'))
    assert kept.bodies[0].inertia is not None
    assert_allclose(kept.bodies[0].inertia.moments, 100, rtol=1e-6)
