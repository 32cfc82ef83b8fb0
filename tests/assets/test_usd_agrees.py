"""What `wmspec run x.usda` takes, a spec takes by `file: "x.usda"`, and it is and moves the same."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pxr import Gf, Usd, UsdGeom

from tests.assets.specs import HERE, checked, scene, spec, tensor
from tests.engines import ENGINES, installed
from tests.language.specs import task_of
from tests.stage.stages import HEADER, lines
from wmspec.compile.design.design import Design
from wmspec.compile.stage.episode import document
from wmspec.compile.stage.layers import compose as composed
from wmspec.core.diagnostics import WmsError
from wmspec.sim.scene.joints.articulations import joint_coordinate, relative_frame
from wmspec.sim.scene.model import Array, Body, Geom, Joint, Scene, Trace
from wmspec.sim.scene.model.bounds import world_box
from wmspec.sim.scene.model.transform import apply, compose, inverse, multiply, rotate, rotation
from wmspec.sim.shapes import SHAPES
from wmspec.sim.usd import read

RIGID = '(prepend apiSchemas = ["PhysicsRigidBodyAPI", "PhysicsCollisionAPI", "MaterialBindingAPI"{}])'
STILL = '(prepend apiSchemas = ["PhysicsCollisionAPI", "MaterialBindingAPI"{}])'
FLOOR = (
    f'def Cube "floor" {STILL.format("")} {{ double size = 1 double3 xformOp:translate = (0, 0, -0.5)'
    ' double3 xformOp:scale = (9, 9, 1) uniform token[] xformOpOrder = ["xformOp:translate", "xformOp:scale"] }'
)


def ball(
    name: str, at: object, more: str = "", apis: str = "", kind: str = "Sphere", size: str = "radius = 0.1"
) -> str:
    return f"""def {kind} "{name}" {RIGID.format(apis)} {{ double {size} double3 xformOp:translate = {at}
        uniform token[] xformOpOrder = ["xformOp:translate"] {more} }}"""


def joined(
    kind: str, name: str, first: str, second: str, at: object, more: str = "", apis: str = '"PhysxJointAPI"'
) -> str:
    """A joint; `at` are its places in the two."""
    ends = "".join(f" rel physics:body{i} = </World/{b}>" for i, b in enumerate((first, second)) if b)
    return f"""def Physics{kind}Joint "{name}" (prepend apiSchemas = [{apis}]) {{ {ends}
        point3f physics:localPos0 = {at[0]} point3f physics:localPos1 = {at[1]} {more} }}"""  # type: ignore[index]


def rubber(name: str, friction: float, restitution: float = 0.0) -> str:
    return f"""def Material "{name}" (prepend apiSchemas = ["PhysicsMaterialAPI"]) {{
        float physics:staticFriction = {friction} float physics:dynamicFriction = {friction}
        float physics:restitution = {restitution} }}"""


def bound(name: str) -> str:
    return f"rel material:binding:physics = </World/{name}>"


BIN = """point3f[] points = [(-1,-1,0),(1,-1,0),(1,1,0),(-1,1,0),(-1,-1,0.5),(1,-1,0.5),(1,1,0.5),(-1,1,0.5)]
int[] faceVertexCounts = [4,4,4,4,4]
int[] faceVertexIndices = [0,1,2,3, 0,1,5,4, 1,2,6,5, 2,3,7,6, 3,0,4,7]"""
SHEET = """point3f[] points = [(-1,-1,0),(1,-1,0),(1,1,0),(-1,1,0)]
int[] faceVertexCounts = [4]
int[] faceVertexIndices = [0,3,2,1]"""
ANGLE = """point3f[] points = [(0,0,0),(0.2,0,0),(0.2,0.1,0),(0.1,0.1,0),(0.1,0.2,0),(0,0.2,0),
(0,0,0.1),(0.2,0,0.1),(0.2,0.1,0.1),(0.1,0.1,0.1),(0.1,0.2,0.1),(0,0.2,0.1)]
int[] faceVertexCounts = [4,4,4,4,4,4,4,4,4,4]
int[] faceVertexIndices = [0,3,2,1, 0,5,4,3, 6,7,8,9, 6,9,10,11,
0,1,7,6, 1,2,8,7, 2,3,9,8, 3,4,10,9, 4,5,11,10, 5,0,6,11]"""
MESHED = ', "PhysicsMeshCollisionAPI"'
DRIVEN = """float drive:{0}:physics:stiffness = {1} float drive:{0}:physics:damping = {2}
    float drive:{0}:physics:targetPosition = {3} float drive:{0}:physics:targetVelocity = {4}
    float drive:{0}:physics:maxForce = {5}"""
LOCKED = ("transX", "transY", "transZ", "rotX", "rotZ")


def mesh(name: str, form: str, way: str, at: object = (0, 0, 1), rigid: bool = True, more: str = "") -> str:
    return f"""def Mesh "{name}" {(RIGID if rigid else STILL).format(MESHED)} {{
        {form}
        uniform token physics:approximation = "{way}"
        double3 xformOp:translate = {at} uniform token[] xformOpOrder = ["xformOp:translate"] {more} }}"""


STAGES = {
    "loose": FLOOR + ball("one", (0, 0, 0.5)) + ball("two", (1, 0, 0.4)) + ball("three", (0.05, 0, 0.9)),
    "thrown": FLOOR
    + ball(
        "one",
        (0, 0, 1),
        "vector3f physics:velocity = (1, 2, 3) vector3f physics:angularVelocity = (90, 20, 10)"
        " float physxRigidBody:linearDamping = 0.5 float physxRigidBody:angularDamping = 0.2",
    ),
    "frictions": rubber("ice", 0.05) + rubber("tar", 0.9, 0.4) + FLOOR
    + f'def Cube "slope" {STILL.format("")} {{ double size = 1 {bound("ice")} double3 xformOp:translate = (2, 0, 0)'
    ' float3 xformOp:rotateXYZ = (0, 30, 0)'
    ' uniform token[] xformOpOrder = ["xformOp:translate", "xformOp:rotateXYZ"] }'
    + ball("bouncy", (0, 0, 0.4), bound("tar"))
    + ball("slides", (2, 0, 0.8), bound("ice"), kind="Cube", size="size = 0.2"),
    "pieces of several materials": rubber("ice", 0.05) + rubber("tar", 0.9) + FLOOR
    + f"""def Xform "skate" (prepend apiSchemas = ["PhysicsRigidBodyAPI"]) {{
        vector3f physics:velocity = (1, 0, 0) double3 xformOp:translate = (0, 0, 0.1)
        uniform token[] xformOpOrder = ["xformOp:translate"]
        def Sphere "front" {STILL.format("")} {{ double radius = 0.1 {bound("ice")}
          double3 xformOp:translate = (0.3, 0, 0) uniform token[] xformOpOrder = ["xformOp:translate"] }}
        def Sphere "back" {STILL.format("")} {{ double radius = 0.1 {bound("tar")} }} }}""",
    "kinematic": FLOOR
    + ball("lift", (0, 0, 0.5), "bool physics:kinematicEnabled = 1", kind="Cube", size="size = 0.4")
    + ball("cargo", (0.1, 0.05, 0.9)),
    "not rigid": FLOOR
    + ball("block", (0, 0, 0.2), "bool physics:rigidBodyEnabled = 0", kind="Cube", size="size = 0.4")
    + ball("cargo", (0.1, 0.05, 0.9)),
    "a chain in the air": ball("a", (0, 0, 1), kind="Cube", size="size = 0.2")
    + ball("b", (0.5, 0, 1))
    + ball("c", (1, 0, 1))
    + joined("Revolute", "ab", "b", "a", ((-0.25, 0, 0), (0.25, 0, 0)), 'uniform token physics:axis = "Y"')
    + joined("Spherical", "bc", "b", "c", ((0.25, 0, 0), (-0.25, 0, 0)))
    + ball("other", (3, 0, 0)),
    "two that hang": ball("a", (0.5, 0, 1)) + ball("b", (2, 0.5, 1)) + ball("c", (5, 0, 2))
    + joined("Revolute", "pin", "", "a", ((0, 0, 1), (-0.5, 0, 0)), 'uniform token physics:axis = "Y"')
    + joined("Revolute", "nail", "b", "", ((0, -0.5, 0), (2, 0, 1))),
    "drives": FLOOR
    + ball("cart", (0, 0, 1), kind="Cube", size="size = 0.2")
    + ball("wheel", (0, 0.3, 1))
    + joined("Prismatic", "rail", "floor", "cart", ((0, 0, 1.5), (0, 0, 0)),
        DRIVEN.format("linear", 50, 9, 0.3, 0, 20)
        + ' float3 physics:unused = (0, 0, 0) uniform token physics:axis = "X"'
        " float physics:lowerLimit = -0.1 float physics:upperLimit = 0.4",
        '"PhysicsDriveAPI:linear"').replace(" float3 physics:unused = (0, 0, 0)", "").replace(
        "(0, 0, 1.5)", "(0, 0, 1.5)")
    + joined("Revolute", "axle", "cart", "wheel", ((0, 0.3, 0), (0, 0, 0)),
        DRIVEN.format("angular", 0, 0.001, 0, 200, 0.05) + ' uniform token physics:axis = "Y"',
        '"PhysicsDriveAPI:angular"'),
    "neighbours that touch": ball("a", (0, 0, 1)) + ball("b", (0.25, 0, 1))
    + joined("Spherical", "hold", "", "a", ((0, 0, 1), (0, 0, 0)))
    + joined("Revolute", "fold", "a", "b", ((0, 0, 0.3), (-0.25, 0, 0.3)),
        'uniform token physics:axis = "Y" bool physics:collisionEnabled = 1'),
    "a hinge by six axes": ball("a", (0.5, 0, 1))
    + joined("", "d6", "", "a", ((0, 0, 1), (-0.5, 0, 0)),
        " ".join(f"float limit:{w}:physics:low = 1 float limit:{w}:physics:high = -1" for w in LOCKED),
        ", ".join(f'"PhysicsLimitAPI:{w}"' for w in LOCKED)),
    "welded": FLOOR + ball("a", (0, 0, 1)) + ball("b", (0.3, 0, 1))
    + joined("Fixed", "weld", "a", "b", ((0.15, 0, 0), (-0.15, 0, 0))),
    "a joint to what is kinematic": ball("post", (0, 0, 1), "bool physics:kinematicEnabled = 1")
    + ball("a", (0.5, 0, 1))
    + joined("Revolute", "pin", "a", "post", ((-0.5, 0, 0), (0, 0, 0)), 'uniform token physics:axis = "Y"'),
    "filtered pairs": FLOOR + f'def Cube "shelf" {STILL.format("")} {{ double size = 0.3'
    ' double3 xformOp:translate = (0, 0, 0.5) uniform token[] xformOpOrder = ["xformOp:translate"] }'
    + ball("ghost", (0, 0, 1), "rel physics:filteredPairs = [</World/shelf>, </World/other>]",
        ', "PhysicsFilteredPairsAPI"')
    + ball("other", (0, 0.02, 0.8)),
    "collision groups": FLOOR + ball("a", (0, 0, 0.5)) + ball("b", (0, 0.02, 0.8)) + ball("c", (0.02, 0, 1.2))
    + 'def PhysicsCollisionGroup "g" (prepend apiSchemas = ["CollectionAPI:colliders"]) {'
    " rel collection:colliders:includes = [</World/a>, </World/b>] rel physics:filteredGroups = </World/g> }",
    "masses": FLOOR + ball("heavy", (0, 0, 0.3), "float physics:mass = 3 point3f physics:centerOfMass = (0.05, 0, 0)"
        " float3 physics:diagonalInertia = (0.01, 0.02, 0.025)"
        " quatf physics:principalAxes = (0.96592583, 0, 0.25881905, 0)",
        ', "PhysicsMassAPI"')
    + ball("light", (1, 0, 0.3), "float physics:density = 20", ', "PhysicsMassAPI"')
    + f"""def Xform "both" (prepend apiSchemas = ["PhysicsRigidBodyAPI"]) {{ double3 xformOp:translate = (2, 0, 0.5)
        float3 xformOp:rotateXYZ = (50, 20, 0)
        uniform token[] xformOpOrder = ["xformOp:translate", "xformOp:rotateXYZ"]
        def Cube "iron" {STILL.format(', "PhysicsMassAPI"')} {{ double size = 0.2 float physics:density = 7800 }}
        def Cone "wood" {STILL.format(', "PhysicsMassAPI"')} {{ double radius = 0.1 double height = 0.4
          float physics:mass = 0.7 double3 xformOp:translate = (0.2, 0, 0)
          uniform token[] xformOpOrder = ["xformOp:translate"] }} }}""",
    "a body without form": """def Xform "bob" (prepend apiSchemas = ["PhysicsRigidBodyAPI", "PhysicsMassAPI"]) {
        float physics:mass = 2 float3 physics:diagonalInertia = (0.1, 0.2, 0.25)
        double3 xformOp:translate = (0.5, 0, 1) uniform token[] xformOpOrder = ["xformOp:translate"] }"""
    + joined("Revolute", "pin", "", "bob", ((0, 0, 1), (-0.5, 0, 0)), 'uniform token physics:axis = "Y"'),
    "a bin": mesh("bin", BIN, "none", (0, 0, 0), rigid=False) + ball("a", (0.3, 0.2, 0.4))
    + ball("b", (0.32, 0.2, 0.8)),
    "a sheet": mesh("ground", SHEET, "none", (0, 0, 0), rigid=False) + ball("a", (0.3, 0.2, 0.4)),
    "meshes": FLOOR + "".join(mesh(w, ANGLE, w, (i, 0, 0.5)) for i, w in
        enumerate(("convexHull", "boundingCube", "boundingSphere"))),
    "a mesh in pieces": FLOOR + mesh("angle", ANGLE, "convexDecomposition", (0, 0, 0.3)),
    "a mesh with a rest": FLOOR + mesh("angle", ANGLE, "convexHull", (0, 0, 0.3), more="""
        def GeomSubset "top" (prepend apiSchemas = ["MaterialBindingAPI"]) { uniform token elementType = "face"
          uniform token familyName = "materialBind" int[] indices = [2, 3] rel material:binding = </World/paint> }""")
    + """def Material "paint" { token outputs:surface.connect = </World/paint/s.outputs:surface>
        def Shader "s" { uniform token info:id = "UsdPreviewSurface" color3f inputs:diffuseColor = (1, 0, 0)
          token outputs:surface } }""",
    "shapes": f'def Plane "ground" {STILL.format("")} {{ uniform token axis = "Z" }}'
    + ball("cone", (0, 0, 1), 'uniform token axis = "X" double height = 0.3', kind="Cone")
    + ball("rod", (2, 0, 1), 'uniform token axis = "Y" double height = 0.5', kind="Capsule")
    + ball("drum", (3, 0, 1), "double radiusBottom = 0.2 double height = 0.3", kind="Cylinder_1",
        size="radiusTop = 0.2")
    + ball("box", (4, 0, 1), "", kind="Cube", size="size = 0.2").replace(
        'uniform token[] xformOpOrder = ["xformOp:translate"]',
        'float3 xformOp:scale = (1, -2, 0.5) uniform token[] xformOpOrder = ["xformOp:translate", "xformOp:scale"]'),
    "names of properties": FLOOR + ball("mass", (0, 0, 0.5)) + ball("base", (1, 0, 0.5)) + ball("color", (2, 0, 0.5))
    + joined("Spherical", "at", "mass", "base", ((0.5, 0, 0), (-0.5, 0, 0))),
    "only drawn": FLOOR + ball("a", (0, 0, 0.5)).replace("}", ' def Sphere "hat" { double radius = 0.05 } }')
    + 'def Cube "backdrop" { double size = 1 }',
}  # fmt: skip
OURS = (
    "specs/prediction/mechanistic/collide", "specs/prediction/mechanistic/slide", "tests/endtoend/specs/speed_tabletop",
)  # fmt: skip


def written(folder: Path, text: str, **header: object) -> Path:
    """A stage in a file."""
    head = HEADER.format(**({"meters": 1, "kilograms": 1, "up": "Z"} | header))
    path = folder / "stage.usda"
    path.write_text(head + lines(f'def Xform "World" {{ {text} }}\n'))
    return path


def both(file: Path, folder: Path, said: str = "") -> tuple[Scene, Scene, dict[str, str]]:
    """The scene of a spec that names a stage, that of the stage itself, and the bodies of this as those of that."""
    expected = replace(read(Usd.Stage.Open(str(file))), actions=(), observations=())
    if file.parent != folder:
        (folder / file.name).write_bytes(file.read_bytes())
    world = f"world {{ gravity: {max(0.0, -expected.gravity[2])} m/s^2 }}\n"
    found = scene(spec(f'{world}object a {{ file: "{file.name}"  at: (0, 0, 0)  {said} }}', folder))
    return found, expected, dict(pairs(found, expected))


def pairs(found: Scene, expected: Scene) -> Iterator[tuple[str, str]]:
    """Bodies that can move or stand for themselves are where they are in the file, each in its place."""
    left = {body.name: body for body in found.bodies}
    for body in expected.bodies:
        if body.motion == "static":
            continue
        near = min(left.values(), key=lambda other: (frame(other, body), other.name))
        assert frame(near, body) < 1e-5  # joints of a stage are written in single precision, ten metres away
        del left[near.name]
        yield body.name, near.name


def frame(one: Body, other: Body) -> float:
    """How far two bodies are apart; those of one name are nearest."""
    named = 0 if one.name == f"a_{other.name}" else 1e-9
    return float(np.abs(apply(one.pose, middle(one)) - apply(other.pose, middle(other))).max()) + named


def middle(body: Body) -> Array:
    """The centre of mass (3,) of a body, or of what never moves the middle of it, in its frame.

    The frame of an asset is that of its base, so the frame of a base may be elsewhere than in the file.
    """
    if body.inertia is not None:
        return body.inertia.center
    return np.asarray(apply(inverse(body.pose), np.mean(world_box(body.geoms, body.pose), axis=0)))


def surfaces(bodies: list[Body]) -> list[tuple[float, ...]]:
    """What is touched of bodies: where each piece reaches to, and how it rubs."""
    found = [(body, geom) for body in bodies for geom in body.geoms if geom.collides]
    return sorted(tuple(np.round(row, 5) + 0.0) for row in (touched(*pair) for pair in found))


def touched(body: Body, geom: Geom) -> Array:
    return np.concatenate([*world_box((geom,), body.pose), (geom.friction.dynamic, geom.friction.restitution)])


def agree(found: Scene, expected: Scene, names: dict[str, str]) -> None:
    """The same bodies, joints and filters, but for how they are called and in which order they come."""
    ours = {body.name: body for body in found.bodies}
    theirs = {body.name: body for body in expected.bodies}
    for name, our in names.items():
        a, b = ours[our], theirs[name]
        assert (a.motion == "dynamic") == (b.motion == "dynamic")
        np.testing.assert_allclose(surfaces([a]), surfaces([b]), atol=2e-5)
        for kind in ("linear_velocity", "angular_velocity", "linear_damping", "angular_damping"):
            np.testing.assert_allclose(getattr(a, kind), getattr(b, kind), rtol=1e-6, atol=1e-6)
        if a.inertia is None or b.inertia is None:
            continue
        assert a.inertia.mass == pytest.approx(b.inertia.mass, rel=1e-6)
        np.testing.assert_allclose(apply(a.pose, a.inertia.center), apply(b.pose, b.inertia.center), atol=1e-5)
        spread = [rotation(x.pose.orientation) @ tensor(x) @ rotation(x.pose.orientation).T for x in (a, b)]
        np.testing.assert_allclose(spread[0], spread[1], atol=1e-5 * np.trace(spread[1]))
    still = [
        [b for b in of.bodies if b.name not in known] for of, known in ((found, names.values()), (expected, names))
    ]
    np.testing.assert_allclose(surfaces(still[0]), surfaces(still[1]), atol=2e-5)
    assert len(found.joints) == len(expected.joints)
    for theirs_ in expected.joints:
        _alike(theirs_, found, expected, names)
    assert len(found.filtered) == len(expected.filtered)
    for pair in expected.filtered:
        known = {names[name] for name in pair if name in names}
        assert any(known <= set(other) for other in found.filtered)


def _alike(expected: Joint, found: Scene, of: Scene, names: dict[str, str]) -> None:
    """A joint of the same kind in the same place, whichever of its bodies comes first."""
    ends = {names[end] for end in (expected.first, expected.second) if end in names}
    joint = next(j for j in found.joints if ends <= {j.first, j.second} and j.kind == expected.kind)
    assert joint.collides == expected.collides
    assert (joint.limits is None) == (expected.limits is None)
    np.testing.assert_allclose(joint.limits or (), expected.limits or (), atol=1e-6)
    assert (joint.drive is None) == (expected.drive is None)
    if joint.drive is not None and expected.drive is not None:
        for kind in ("stiffness", "damping", "target", "velocity", "max_force"):
            assert getattr(joint.drive, kind) == pytest.approx(getattr(expected.drive, kind), rel=1e-5)
    places = []
    for one, scene_ in ((joint, found), (expected, of)):
        bodies = {body.name: body for body in scene_.bodies}
        start = relative_frame(bodies, one.first, one.second, one.first_frame, one.second_frame)
        at = compose(bodies[one.second].pose, one.second_frame)
        axis = rotate(at.orientation, np.array([1.0, 0, 0]))
        places.append((joint_coordinate(one, start) if one.kind != "fixed" else 0.0, at.position, axis))
    if joint.kind != "fixed":
        np.testing.assert_allclose(places[0][1], places[1][1], atol=1e-5)
        assert places[0][0] == pytest.approx(places[1][0], abs=1e-5)
    if joint.kind in ("hinge", "slider"):  # turned round with its ends
        way = 1 if names.get(expected.second) == joint.second else -1
        np.testing.assert_allclose(places[0][2], way * places[1][2], atol=1e-5)


def run(engine: str, found: Scene, expected: Scene, names: dict[str, str], seconds: float, hit: float) -> None:
    """They move the same within 0.1 mm; after the first impact, which multiplies the least difference, within `hit`.

    What an engine lacks of one it lacks of the other.
    """
    execute = installed(engine).execute
    ours_, theirs_ = (replace(of, duration=seconds, rate=240) for of in (found, expected))
    try:
        other = execute(theirs_)
    except WmsError:
        with pytest.raises(WmsError):
            execute(ours_)
        return
    one = execute(ours_)
    ours, theirs = ({body.name: body for body in of.bodies} for of in (found, expected))
    first = np.searchsorted(one.time, min((contact.start for contact in one.contacts), default=np.inf)) - 1
    for name, our in names.items():
        a, b = (moved(trace, body) for trace, body in ((one, ours[our]), (other, theirs[name])))
        turned = np.abs(multiply(a[1], b[1] * (1, -1, -1, -1))[:, 1:]).max(axis=1)
        apart = np.abs(a[0] - b[0]).max(axis=1)
        assert max(apart[:first].max(initial=0), turned[:first].max(initial=0)) < 1e-4
        assert max(apart.max(), turned.max() / 10) < hit


def moved(trace: Trace, body: Body) -> tuple[Array, Array]:
    """Where the centre of mass of a body is (T, 3), and how it is turned against the start (T, 4)."""
    i = trace.bodies.index(body.name)
    at, turned = trace.position[:, i], trace.orientation[:, i]
    return at + rotate(turned, middle(body)), multiply(turned, turned[:1] * (1, -1, -1, -1))


@pytest.mark.parametrize("name", STAGES)
def test_a_stage_is_the_same_in_a_spec(tmp_path: Path, name: str) -> None:
    agree(*both(written(tmp_path, STAGES[name]), tmp_path))


@pytest.mark.parametrize("units", [{"meters": 0.01, "up": "Y"}, {"kilograms": 1e-3, "up": "X"}], ids=str)
@pytest.mark.parametrize("name", ["thrown", "drives", "masses", "a bin", "shapes"])
def test_units_and_up_axes(tmp_path: Path, name: str, units: dict[str, object]) -> None:
    agree(*both(written(tmp_path, STAGES[name], **units), tmp_path))


def test_a_file_is_the_same_in_a_spec(tmp_path: Path) -> None:
    agree(*both(HERE / "balance.usda", tmp_path))


@pytest.mark.parametrize("name", OURS)
def test_exported_stage_is_the_same_in_a_spec(tmp_path: Path, name: str) -> None:
    """Whose materials are pictures that lie elsewhere, so that the spec has to say its colours."""
    design = Design(task_of(HERE.parents[1] / f"{name}.wms"))
    file = tmp_path / "made" / "stage.usda"
    file.parent.mkdir()
    composed(document(design.spec, design[0])).Export(str(file))
    agree(*both(file, tmp_path, "color: red"))


@pytest.mark.parametrize("name", STAGES)
def test_a_stage_moves_the_same_in_a_spec(tmp_path: Path, name: str) -> None:
    run("mujoco", *both(written(tmp_path, STAGES[name]), tmp_path), 0.6, 1e-3)


@pytest.mark.slow
@pytest.mark.parametrize("engine", [engine for engine in ENGINES if engine != "mujoco"])
@pytest.mark.parametrize("name", STAGES)
def test_a_stage_moves_the_same_in_a_spec_and_every_engine(tmp_path: Path, engine: str, name: str) -> None:
    run(engine, *both(written(tmp_path, STAGES[name]), tmp_path), 0.4, 3e-2)


def test_shapes_of_ours_that_usd_does_not_have(tmp_path: Path) -> None:
    """A stage of every shape of the language is read as these shapes, and so a spec says them."""
    text = "".join(
        f"object o{i} {{ shape: {kind}  {more}  at: ({i} m, 0, 1 m)  fixed: {str(kind == 'plane').lower()} }}\n"
        for i, (kind, more) in enumerate(
            {
                **{kind: "size: 20 cm" for kind, shape in SHAPES.items() if shape.accepts("size")},
                "sweep": "thickness: 2 cm  along: [(0 cm, 0 cm, 0 cm), (20 cm, 0 cm, 0 cm), (20 cm, 10 cm, 5 cm)]",
                "lathe": "profile: [(0 cm, 0 cm), (10 cm, 0 cm), (4 cm, 20 cm)]",
                "extrude": "depth: 10 cm  outline: [(0 cm, 0 cm), (20 cm, 0 cm), (20 cm, 10 cm), (10 cm, 20 cm)]",
            }.items()
        )
    )
    made = spec(text, tmp_path)
    file = tmp_path / "made" / "stage.usda"
    file.parent.mkdir()
    composed(document(made, Design(made)[0])).Export(str(file))
    found, expected, names = both(file, tmp_path, "color: red")
    agree(found, expected, names)
    for name, our in names.items():
        ours, theirs = (next(b for b in of.bodies if b.name == n) for of, n in ((found, our), (expected, name)))
        assert [type(g.shape) for g in ours.geoms] == [type(g.shape) for g in theirs.geoms]


#: What a stage may have and a spec may not, and what is said about it.
BEYOND = {
    "limits of ball joints are not supported in a spec": ball("a", (0.5, 0, 1))
    + joined("Spherical", "hook", "", "a", ((0, 0, 1), (-0.5, 0, 0)), "float physics:coneAngle0Limit = 30"),
    "`friction` must be at most 5": rubber("glue", 6) + ball("a", (0, 0, 1), bound("glue")),
    "`damping` must be at most 100": ball("a", (0, 0, 1), "float physxRigidBody:linearDamping = 200"),
}


@pytest.mark.parametrize("message", BEYOND)
def test_unsupported_parts_of_a_stage_are_reported_in_specs(tmp_path: Path, message: str) -> None:
    read(Usd.Stage.Open(str(written(tmp_path, BEYOND[message]))))
    (tmp_path / "spec.wms").write_text('task t : custom { object a { file: "stage.usda"  at: (0, 0, 0) } }')
    reported = checked(tmp_path / "spec.wms")[1].diagnostics
    assert any(message in d.message for d in reported), reported


# ---------------------------------------------------------------- any tree of bodies

_NUMBER = st.integers(-20, 20).map(lambda n: n / 10)
_PLACE = st.tuples(_NUMBER, _NUMBER, _NUMBER)
_TURN = st.tuples(*[st.sampled_from([0, 30, -75, 90, 140])] * 3)
_SHAPES = {
    "Cube": "double size = 0.2",
    "Sphere": "double radius = 0.1",
    "Cylinder": "double radius = 0.1 double height = 0.4",
    "Cone": "double radius = 0.1 double height = 0.4",
    "Capsule": "double radius = 0.1 double height = 0.3",
}
_KINDS = ("Revolute", "Prismatic", "Spherical", "Fixed")


@st.composite
def trees(draw: st.DrawFn) -> str:
    """A stage of some bodies, each free or held by the world or one before it, in whichever order the joint says it."""
    text = ""
    made = Usd.Stage.CreateInMemory()
    poses: list[Gf.Matrix4d] = []
    for i in range(draw(st.integers(1, 4))):
        x, y, z = draw(_PLACE)
        at = (x, y, z + 5 * i)  # no two in one place
        turn, kind = draw(_TURN), draw(st.sampled_from(sorted(_SHAPES)))
        more = draw(st.sampled_from(["", "float physics:mass = 2", "float physics:density = 50"]))
        axis = "" if kind in ("Cube", "Sphere") else f'uniform token axis = "{draw(st.sampled_from("XYZ"))}"'
        text += f"""def {kind} "b{i}" {RIGID.format(', "PhysicsMassAPI"')} {{ {_SHAPES[kind]} {more} {axis}
            double3 xformOp:translate = {at} float3 xformOp:rotateXYZ = {turn}
            uniform token[] xformOpOrder = ["xformOp:translate", "xformOp:rotateXYZ"] }}"""
        api = UsdGeom.XformCommonAPI(UsdGeom.Xform.Define(made, f"/b{i}"))
        api.SetTranslate(at)
        api.SetRotate(turn)
        poses.append(UsdGeom.XformCache().GetLocalToWorldTransform(api.GetPrim()))
        held = draw(st.sampled_from([None, "", *(f"b{j}" for j in range(i))]))
        if held is not None:
            joint = draw(st.sampled_from(_KINDS if held else _KINDS[:3]))  # what is fixed to the world is the world
            text += _held(draw, joint, held, i, poses)
    return text


def _held(draw: st.DrawFn, kind: str, held: str, i: int, poses: list[Gf.Matrix4d]) -> str:
    """A joint at a place in the world, turned somehow, whose ends meet there."""
    spot, turn = Gf.Vec3d(*draw(_PLACE)), Gf.Rotation(Gf.Vec3d(1, 2, draw(st.integers(-3, 3))), 40 * i)
    ends = [(held, poses[int(held[1:])] if held else Gf.Matrix4d(1)), (f"b{i}", poses[i])]
    if draw(st.booleans()):
        ends.reverse()
    axis, twist = draw(st.sampled_from("XYZ")), draw(st.sampled_from([0, -15, 5])) if kind == "Revolute" else 0
    along = Gf.Rotation(Gf.Vec3d(*("XYZ"[k] == axis for k in range(3))), twist)
    said = f'uniform token physics:axis = "{axis}"' if kind != "Fixed" else ""
    for number, (name, pose) in enumerate(ends):
        back = pose.GetInverse()
        at, q = (
            back.Transform(spot),
            ((along if number else Gf.Rotation(Gf.Vec3d(1, 0, 0), 0)) * turn * back.ExtractRotation()).GetQuat(),
        )
        said += f" rel physics:body{number} = </World/{name}>" if name else ""
        said += f" point3f physics:localPos{number} = {tuple(at)}"
        said += f" quatf physics:localRot{number} = ({q.GetReal()}, {', '.join(map(str, q.GetImaginary()))})"
    if kind in ("Revolute", "Prismatic") and draw(st.booleans()):
        said += " float physics:lowerLimit = -20 float physics:upperLimit = 10"
    return f'def Physics{kind}Joint "j{i}" {{ {said} }}'


@settings(max_examples=20, deadline=None)
@given(text=trees())
def test_any_tree_of_bodies_is_the_same_in_a_spec(tmp_path_factory: pytest.TempPathFactory, text: str) -> None:
    folder = tmp_path_factory.mktemp("tree")
    agree(*both(written(folder, text), folder))
