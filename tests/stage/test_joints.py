"""Joints, drives, filters and cameras on bodies of UsdPhysics are read as what they mean, in SI units and Z up."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.testing import assert_allclose

from tests.stage.stages import assert_same, stage
from wmspec.core.diagnostics import StageError
from wmspec.sim.scene.joints.articulations import joint_coordinate
from wmspec.sim.scene.model import Camera, Drive, Joint, Steer
from wmspec.sim.scene.model.transform import apply, compose, inverse, rotate
from wmspec.sim.usd import read

BODY = """def Cube "%s" (prepend apiSchemas = ["PhysicsRigidBodyAPI", "PhysicsCollisionAPI"]) { double size = 0.2
    double3 xformOp:translate = %s quatf xformOp:orient = %s
    uniform token[] xformOpOrder = ["xformOp:translate", "xformOp:orient"] }"""
TURNED = "(0.70710678, 0, 0, 0.70710678)"
BODIES = BODY % ("a", "(0, 0, 1)", "(1, 0, 0, 0)") + BODY % ("b", "(1, 0, 1)", TURNED)
FRAMES = """point3f physics:localPos0 = (0.5, 0, 0)
    quatf physics:localRot0 = (1, 0, 0, 0)
    point3f physics:localPos1 = (0, 0.5, 0)
    quatf physics:localRot1 = (0.70710678, 0, 0, -0.70710678)"""
JOINT = """def Physics%sJoint "j" (prepend apiSchemas = [%s]) { rel physics:body0 = </World/a>
    rel physics:body1 = </World/b>
    %s
    %s }"""
HARMLESS = '"PhysxJointAPI"'
X = np.array([1.0, 0, 0])


def joint(kind: str, more: str = "", apis: str = HARMLESS) -> str:
    """A joint between a and b."""
    return JOINT % (kind, apis, FRAMES, more)


def only(kind: str, more: str = "", apis: str = HARMLESS, bodies: str = BODIES, **header: float | str) -> Joint:
    """The one joint between a and b."""
    (found,) = read(stage(bodies + joint(kind, more, apis), **header)).joints  # type: ignore[arg-type]
    return found


def test_the_kinds() -> None:
    assert (only("Fixed").kind, only("Fixed").limits) == ("fixed", None)
    hinge = only("Revolute", "float physics:lowerLimit = -90\nfloat physics:upperLimit = 45")
    assert (hinge.kind, hinge.name, hinge.first, hinge.second, hinge.collides) == ("hinge", "j", "a", "b", False)
    assert hinge.limits is not None
    assert_allclose(hinge.limits, (-math.pi / 2, math.pi / 4))
    slider = only("Prismatic", "float physics:lowerLimit = -0.1\nbool physics:collisionEnabled = 1")
    assert (slider.kind, slider.limits, slider.collides) == ("slider", (pytest.approx(-0.1), math.inf), True)
    ball = only("Spherical", "float physics:coneAngle0Limit = 30")
    assert ball.kind == "ball"
    assert ball.limits is not None
    assert_allclose(ball.limits, (math.pi / 6, math.pi))
    assert only("Spherical").limits is None


@pytest.mark.parametrize(("axis", "way"), [("X", (1, 0, 0)), ("Y", (0, 1, 0)), ("Z", (0, 0, 1))])
def test_the_axis_is_x_of_both_frames(axis: str, way: tuple[float, ...]) -> None:
    scene = read(stage(BODIES + JOINT % ("Revolute", HARMLESS, FRAMES, f'uniform token physics:axis = "{axis}"')))
    (joint,), poses = scene.joints, {body.name: body.pose for body in scene.bodies}
    first, second = compose(poses["a"], joint.first_frame), compose(poses["b"], joint.second_frame)
    assert_allclose(first.position, (0.5, 0, 1), atol=1e-6)
    assert_allclose(second.position, (0.5, 0, 1), atol=1e-6)
    assert_allclose(rotate(first.orientation, X), way, atol=1e-6)
    assert_allclose(rotate(second.orientation, X), way, atol=1e-6)


def test_the_world_at_either_end_keeps_the_sign_of_the_coordinate() -> None:
    """A body turned by 0.5 rad about the axis is at 0.5 as body 1, and at -0.5 as body 0."""
    turned = BODY % ("b", "(0, 0, 1)", f"({math.cos(0.25)}, {math.sin(0.25)}, 0, 0)")
    frames = "point3f physics:localPos0 = (0, 0, %d)\npoint3f physics:localPos1 = (0, 0, %d)"
    for number, places, expected in ((1, (1, 0), 0.5), (0, (0, 1), -0.5)):
        text = f'def PhysicsRevoluteJoint "j" {{ rel physics:body{number} = </World/b>\n{frames % places} }}'
        scene = read(stage(turned + text))
        (joint,), (body,) = scene.joints, scene.bodies
        assert (joint.first, joint.second) == (None, "b")
        found = compose(inverse(joint.first_frame), compose(body.pose, joint.second_frame))
        assert_allclose(joint_coordinate(joint, found), expected, atol=1e-6)


def test_static_ends_are_the_world_and_joints_of_nothing_are_left_out() -> None:
    wall = BODY.replace('"PhysicsRigidBodyAPI", ', "") % ("a", "(0, 0, 1)", "(1, 0, 0, 0)")
    joint = only("Revolute", bodies=wall + BODY % ("b", "(1, 0, 1)", TURNED))
    assert (joint.first, joint.second) == ("a", "b")
    assert_allclose(joint.first_frame.position, (0.5, 0, 0), atol=1e-6)
    assert (
        read(
            stage(
                wall
                + BODY % ("b", "(1, 0, 1)", TURNED)
                + JOINT % ("Fixed", HARMLESS, FRAMES, "bool physics:jointEnabled = 0")
            )
        ).joints
        == ()
    )
    walls = wall + wall.replace('"a"', '"b"')
    assert read(stage(walls + JOINT % ("Fixed", HARMLESS, FRAMES, ""))).joints == ()


DRIVE = """float drive:%s:physics:stiffness = 10
    float drive:%s:physics:damping = 2
    float drive:%s:physics:targetPosition = 30
    float drive:%s:physics:targetVelocity = 5
    float drive:%s:physics:maxForce = 7"""


@pytest.mark.parametrize("name", ["newton:armature", "mjc:armature", "physxJoint:armature"])
def test_armatures_in_other_units(name: str) -> None:
    hinge, slider = (only(kind, f"float {name} = 3", meters=0.1, kilograms=2) for kind in ("Revolute", "Prismatic"))
    assert (hinge.armature, slider.armature) == (pytest.approx(3 * 2 * 0.1**2), pytest.approx(3 * 2))
    assert only("Fixed", f"float {name} = 3").armature == 0
    with pytest.raises(StageError, match=f"/World/j: {name} = -1; author 0 or more"):
        only("Revolute", f"float {name} = -1")
    with pytest.raises(StageError, match=f"/World/j: {name} of a ball joint is not supported"):
        only("Spherical", f"float {name} = 3")


def test_drives_in_other_units() -> None:
    """A stage in centimetres and grams: forces are in g cm/s²; angles are in degrees on any stage."""
    turned = only("Revolute", DRIVE.replace("%s", "angular"), '"PhysicsDriveAPI:angular"', meters=0.01, kilograms=1e-3)
    way = math.radians(1)
    assert_same(turned.drive, Drive(1e-7 * 10 / way, 1e-7 * 2 / way, 30 * way, 5 * way, 7e-7))
    slid = only("Prismatic", DRIVE.replace("%s", "linear"), '"PhysicsDriveAPI:linear"', meters=0.01, kilograms=1e-3)
    assert_same(slid.drive, Drive(1e-3 * 10, 1e-3 * 2, 0.3, 0.05, 7e-5))


def locked(*ways: str) -> tuple[str, str]:
    """The limits that lock degrees of freedom of a generic joint, and the schemas that they need."""
    lines = (f"float limit:{way}:physics:low = 1\nfloat limit:{way}:physics:high = -1" for way in ways)
    return "\n".join(lines), ", ".join(f'"PhysicsLimitAPI:{way}"' for way in ways)


def test_generic_joints_equal_to_a_known_kind() -> None:
    all_ = ("transX", "transY", "transZ", "rotX", "rotY", "rotZ")
    assert only("", *locked(*all_)).kind == "fixed"
    assert only("", *locked(*all_[:3])).kind == "ball"
    more, apis = locked(*(way for way in all_ if way != "rotZ"))
    drive = DRIVE.replace("%s", "rotZ")
    hinge = only("", more + "\n" + drive, apis + ', "PhysicsDriveAPI:rotZ"')
    assert hinge.kind == "hinge"
    assert hinge.drive is not None
    assert_allclose(rotate(hinge.first_frame.orientation, X), (0, 0, 1), atol=1e-6)
    more, apis = locked(*(way for way in all_ if way != "transY"))
    limit = "float limit:transY:physics:low = -2\nfloat limit:transY:physics:high = 3"
    slider = only("", more + "\n" + limit, apis + ', "PhysicsLimitAPI:transY"')
    assert (slider.kind, slider.limits) == ("slider", (-2.0, 3.0))


SLIDES = ("transX", "transY", "transZ")
DRIVE_Y = "\n" + DRIVE.replace("%s", "rotY")

REFUSED = {
    "distance": (joint("Distance"), "distance joints"),
    "two ways": (joint(""), "leaves transX, transY"),
    "breaks": (joint("Fixed", "float physics:breakForce = 10"), "break"),
    "limits": (
        joint("Revolute", "float physics:lowerLimit = 9\nfloat physics:upperLimit = 3"),
        "limits",
    ),
    "equal": (
        joint("Revolute", "float physics:lowerLimit = 3\nfloat physics:upperLimit = 3"),
        "equal",
    ),
    "itself": (joint("Fixed").replace("/World/b", "/World/a"), "to itself"),
    "nobody": (joint("Fixed").replace("/World/b", "/World/c"), "not on the stage"),
    "strange drive": (
        joint("Revolute", DRIVE.replace("%s", "linear"), '"PhysicsDriveAPI:linear"'),
        "drive 'linear' is on a locked axis",
    ),
    "drive of a ball": (
        joint("Spherical", DRIVE.replace("%s", "rotX"), '"PhysicsDriveAPI:rotX"'),
        "drive 'rotX' belongs to a ball joint",
    ),
    "drive of a generic ball": (
        joint("", locked(*SLIDES)[0] + DRIVE_Y, locked(*SLIDES)[1] + ', "PhysicsDriveAPI:rotY"'),
        "drive 'rotY' belongs to a ball joint",
    ),
    "animated drive": (
        joint(
            "Revolute", "float drive:angular:physics:stiffness.timeSamples = {0: 1, 24: 2}", '"PhysicsDriveAPI:angular"'
        ),
        "drive:angular:physics:stiffness is animated",
    ),
    "animated enabling": (
        joint("Fixed", "bool physics:jointEnabled.timeSamples = {0: 1, 24: 0}"),
        "physics:jointEnabled is animated",
    ),
    "limit without number": (
        joint("Revolute", "float physics:lowerLimit = nan"),
        "lowerLimit = nan",
    ),
    "limits without end": (
        joint("Prismatic", "float physics:lowerLimit = inf"),
        "its limits are inf",
    ),
    "frame": (
        JOINT % ("Fixed", HARMLESS, FRAMES.replace("(0.5, 0, 0)", "(nan, 0, 0)"), ""),
        "localPos0 = .nan, 0, 0. is",
    ),
    "stiffness": (
        joint("Revolute", "float drive:angular:physics:stiffness = inf", '"PhysicsDriveAPI:angular"'),
        "stiffness = inf is not finite",
    ),
    "acceleration": (
        joint(
            "Revolute",
            DRIVE.replace("%s", "angular") + '\nuniform token drive:angular:physics:type = "acceleration"',
            '"PhysicsDriveAPI:angular"',
        ),
        "by acceleration",
    ),
    "gear": ('def PhysxPhysicsGearJoint "j" {}', "gears"),
    "mimic": (joint("Revolute", apis='"PhysxMimicJointAPI:rotX"'), "mimic"),
}


@pytest.mark.parametrize("case", REFUSED)
def test_unsupported_input_is_refused(case: str) -> None:
    text, reason = REFUSED[case]
    with pytest.raises(StageError, match=reason) as caught:
        read(stage(BODIES + text))
    assert [str(problem.place) for problem in caught.value.diagnostics] == ["/World/j"]


def test_a_drive_is_steered() -> None:
    steer = """def WmsAction "s" { uniform token wms:verb = "drive" rel wms:joint = </World/j>
        uniform double wms:start = 0.5
        uniform double wms:target = 1.5 }"""
    driven = JOINT % ("Revolute", '"PhysicsDriveAPI:angular"', FRAMES, DRIVE.replace("%s", "angular"))
    assert read(stage(BODIES + driven + steer)).actions == (Steer("s", "j", 0.5, 1.5),)
    with pytest.raises(StageError, match="/World/s: /World/j has no drive"):
        read(stage(BODIES + JOINT % ("Revolute", HARMLESS, FRAMES, "") + steer))


# ---------------------------------------------------------------- filters

THREE = "".join(BODY % (name, f"({i}, 0, 1)", "(1, 0, 0, 0)") for i, name in enumerate("abc"))


def test_filtered_pairs() -> None:
    text = THREE.replace(
        '"a" (prepend apiSchemas = ["PhysicsRigidBodyAPI"',
        '"a" (prepend apiSchemas = ["PhysicsFilteredPairsAPI", "PhysicsRigidBodyAPI"',
    ).replace("double size", "rel physics:filteredPairs = [</World/c>, </World/b>]\ndouble size", 1)
    assert read(stage(text)).filtered == (("a", "b"), ("a", "c"))


def test_collision_groups() -> None:
    group = """def PhysicsCollisionGroup "%s" (prepend apiSchemas = ["CollectionAPI:colliders"]) {
        rel collection:colliders:includes = [%s]
        rel physics:filteredGroups = [%s] }"""
    text = THREE + group % ("g", "</World/a>, </World/b>", "</World/h>") + group % ("h", "</World/c>", "")
    assert read(stage(text)).filtered == (("a", "c"), ("b", "c"))
    alone = THREE + group % ("g", "</World/a>, </World/b>", "</World/g>")
    assert read(stage(alone)).filtered == (("a", "b"),)
    inverted = (THREE + group % ("g", "</World/a>", "</World/g>")).replace(
        "rel physics:filteredGroups", "bool physics:invertFilteredGroups = 1\nrel physics:filteredGroups"
    )
    assert read(stage(inverted + group % ("h", "</World/b>", ""))).filtered == (("a", "b"),)


def test_an_articulation_without_collisions_of_its_own() -> None:
    joints = "".join(
        f"""def PhysicsRevoluteJoint "j{i}" {{ rel physics:body0 = </World/r/{a}>
            rel physics:body1 = </World/r/{b}> {FRAMES} }}"""
        for i, (a, b) in enumerate((("a", "b"), ("b", "c")))
    )
    root = f"""def Xform "r" (prepend apiSchemas = ["PhysicsArticulationRootAPI"]) {{
        bool physxArticulation:enabledSelfCollisions = 0 {THREE} {joints} }}"""
    assert read(stage(root)).filtered == (("a", "b"), ("a", "c"), ("b", "c"))
    assert read(stage(root.replace("= 0", "= 1"))).filtered == ()


def test_half_a_body_cannot_pass_through() -> None:
    two = """def Xform "a" (prepend apiSchemas = ["PhysicsRigidBodyAPI"]) {
        def Cube "x" (prepend apiSchemas = ["PhysicsCollisionAPI", "PhysicsFilteredPairsAPI"]) {
            rel physics:filteredPairs = </World/b> }
        def Sphere "y" (prepend apiSchemas = ["PhysicsCollisionAPI"]) {} }"""
    with pytest.raises(StageError, match="/World/a: only some of its colliders are filtered against /World/b"):
        read(stage(two + BODY % ("b", "(9, 0, 0)", "(1, 0, 0, 0)")))


# ---------------------------------------------------------------- cameras


def test_a_camera_below_a_body_rides_on_it() -> None:
    camera = """def Camera "eye" { double3 xformOp:translate = (0, 0, 0.5)
        uniform token[] xformOpOrder = ["xformOp:translate"] }"""
    text = (BODY % ("b", "(1, 0, 1)", TURNED)).replace("double size", camera + "\ndouble size")
    scene = read(stage(text))
    (eye,) = scene.cameras
    assert isinstance(eye, Camera)
    assert eye.body == "b"
    assert_allclose(eye.pose.position, (0, 0, 0.5), atol=1e-7)
    assert_allclose(apply(scene.bodies[0].pose, eye.pose.position), (1, 0, 1.5), atol=1e-7)
    still = read(stage(text.replace('"PhysicsRigidBodyAPI", ', ""))).cameras[0]
    assert still.body is None
    assert_allclose(still.pose.position, (1, 0, 1.5), atol=1e-7)
