"""A stage, ours or anyone's, is read correctly, or refused with all its obstacles."""

from __future__ import annotations

import math
import pickle
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose
from pxr import Gf, Usd, UsdPhysics, UsdValidation

from tests.stage.stages import DATA, assert_same, lines, stage
from wmspec.core.diagnostics import StageError
from wmspec.sim.scene.model import Body, Friction, Glide, Launch
from wmspec.sim.scene.model.transform import rotation
from wmspec.sim.shapes import Box, Capsule, Cone, Cylinder, Mesh, Sphere
from wmspec.sim.usd import read

BALL = """
def Sphere "ball" (prepend apiSchemas = ["PhysicsRigidBodyAPI", "PhysicsCollisionAPI", "PhysicsMassAPI"]) {
    double radius = 0.1
    float physics:mass = 2
    double3 xformOp:translate = (0, 0, 1)
    uniform token[] xformOpOrder = ["xformOp:translate"]
    %s
}"""


def opened(name: str) -> Usd.Stage:
    """A stage of the data folder."""
    return Usd.Stage.Open(str(DATA / name))


def only(text: str, **header: float | str) -> Body:
    """The one body of an inline stage."""
    (body,) = read(stage(text, **header)).bodies  # type: ignore[arg-type]
    return body


def problems(text: str) -> dict[str, str]:
    """Path -> reason of everything that is refused."""
    with pytest.raises(StageError) as caught:
        read(stage(text))
    assert all(p.help for p in caught.value.diagnostics)
    return {str(p.place): p.message for p in caught.value.diagnostics}


# ---------------------------------------------------------------- our own stages


def test_bodies_of_our_stage() -> None:
    scene = read(opened("collide.usda"))
    assert [(b.name, b.motion) for b in scene.bodies] == [
        ("floor", "static"),
        ("ball", "dynamic"),
        ("cube", "dynamic"),
        ("cart", "kinematic"),
    ]
    floor, ball, cube, cart = scene.bodies
    assert_same(floor.geoms[0].shape, Box((2.0, 2.0, 0.1)))
    assert_same(ball.geoms[0].friction, Friction(0.9, 0.8, 0.6))
    assert_same(ball.geoms[0].surface.color, (0.8, 0.2, 0.2))
    assert ball.inertia is not None
    assert cube.inertia is not None
    assert cart.inertia is None
    assert_allclose(ball.inertia.moments, 0.4 * 0.2 * 0.05**2)
    assert_allclose(ball.angular_velocity, (0, 0, math.pi / 2))
    assert_allclose(cube.inertia.mass, 0.6)
    assert_allclose(cube.pose.orientation, (math.cos(math.pi / 12), 0, 0, math.sin(math.pi / 12)))
    assert [(g.name, g.collides) for g in cube.geoms] == [("block", True), ("hat", False)]
    assert_allclose(rotation(cart.geoms[0].pose.orientation) @ (0, 0, 1), (1, 0, 0), atol=1e-12)
    assert_allclose(rotation(cart.geoms[1].pose.orientation) @ (0, 0, 1), (0, 1, 0), atol=1e-12)


def test_episode_of_our_stage() -> None:
    scene = read(opened("collide.usda"))
    assert (scene.name, scene.duration, scene.rate) == ("prediction/mechanistic/collide", 2.0, 240)
    push, ride = scene.actions
    assert_same(push, Launch("push", "ball", 0.25, np.array((1.2, 0, 0)), np.array((0, 24.0, 0))))
    assert_same(ride, Glide("ride", "cart", 0.5, 1.5, np.array((0, -0.3, 0.4))))
    assert scene.observations[0].camera == scene.cameras[0].name == "front"
    assert scene.observations[0].times == (0, 0.25, 0.5)
    assert_allclose(scene.cameras[0].fovy, 2 * math.atan(0.5))
    assert_allclose(scene.light.direction, (0, math.sqrt(0.5), -math.sqrt(0.5)))
    assert_allclose((scene.light.diffuse, scene.light.ambient), (0.65, 0.35))


def test_units_up_axis_reference_and_scale_change_nothing() -> None:
    assert_same(read(opened("nested.usda")), read(opened("collide.usda")))


@pytest.mark.parametrize("name", ["collide.usda", "nested.usda"])
def test_usd_validates_our_stages(name: str) -> None:
    validators = UsdValidation.ValidationRegistry().GetOrLoadAllValidators()
    errors = UsdValidation.ValidationContext(validators).Validate(opened(name))
    assert [str(e.GetErrorAsString()) for e in errors] == []


def test_reading_twice_gives_the_same_bits() -> None:
    assert pickle.dumps(read(opened("collide.usda"))) == pickle.dumps(read(opened("collide.usda")))


# ---------------------------------------------------------------- shapes and transforms

TRIANGLE = """def Mesh "x" { point3f[] points = [(0, 0, 0), (1, 0, 0), (0, 1, 0)]
    int[] faceVertexCounts = [3] int[] faceVertexIndices = [0, 1, 2] %s }"""


@pytest.mark.parametrize(
    ("prim", "shape"),
    [
        ('def Cube "x" {double size = 2 %s}', Box((2.0, 3.0, 4.0))),
        ('def Cylinder "x" {uniform token axis = "X" double height = 2 double radius = 1 %s}', None),
        (TRIANGLE, Mesh(np.array([(0, 0, 0), (2, 0, 0), (0, 3, 0)], float), np.array([[0, 1, 2]], np.int32))),
    ],
)
def test_scale_that_is_not_uniform(prim: str, shape: Box | Mesh | None) -> None:
    text = prim % 'double3 xformOp:scale = (2, 3, 4) uniform token[] xformOpOrder = ["xformOp:scale"]'
    if shape is None:
        assert problems(text) == {"/World/x": "its scale makes its round section elliptic"}
    else:
        assert_same(only(text).geoms[0].shape, shape)


@pytest.mark.parametrize(
    ("prim", "shape"),
    [
        ('Cylinder "x" {uniform token axis = "Y" double radius = 1 double height = 3 ', Cylinder(2.0, 15.0)),
        ('Cone "x" {uniform token axis = "Y" double radius = 1 double height = 3 ', Cone(2.0, 15.0)),
        ('Cylinder_1 "x" {uniform token axis = "Y" double radiusTop = 1 double radiusBottom = 1 double height = 3 ',
         Cylinder(2.0, 15.0)),
    ],
)  # fmt: skip
def test_scale_along_the_axis(prim: str, shape: Cylinder | Cone) -> None:
    scale = 'double3 xformOp:scale = (2, 5, 2) uniform token[] xformOpOrder = ["xformOp:scale"]'
    (geom,) = only(f"def {prim} {scale} }}").geoms
    assert_same(geom.shape, shape)
    assert_allclose(rotation(geom.pose.orientation) @ (0, 0, 1), (0, 1, 0), atol=1e-12)


@pytest.mark.parametrize("axis", "XYZ")
@pytest.mark.parametrize("mirrored", "XYZ")
def test_the_apex_of_a_mirrored_cone(axis: str, mirrored: str) -> None:
    scale = tuple(-1 if m == mirrored else 1 for m in "XYZ")
    body = only(
        f'def Cone "x" {{uniform token axis = "{axis}" double3 xformOp:scale = {scale} '
        'uniform token[] xformOpOrder = ["xformOp:scale"]}'
    )
    turn = rotation(body.pose.orientation) @ rotation(body.geoms[0].pose.orientation)
    apex = np.array([float(a == axis) for a in "XYZ"]) * (-1 if axis == mirrored else 1)
    assert_allclose(turn @ (0, 0, 1), apex, atol=1e-12)


def test_schema_fallbacks_of_shapes() -> None:
    kinds = {
        "Cube": Box((1.0, 1.0, 1.0)),
        "Sphere": Sphere(1.0),
        "Cylinder": Cylinder(1.0, 2.0),
        "Cone": Cone(1.0, 2.0),
    }
    kinds["Capsule"] = Capsule(0.5, 1.0)
    for kind, shape in kinds.items():
        assert_same(only(f'def {kind} "x" {{}}').geoms[0].shape, shape)


QUAD_BOX = """
    point3f[] points = [(0,0,0),(1,0,0),(1,1,0),(0,1,0),(0,0,1),(1,0,1),(1,1,1),(0,1,1),(9,9,9)]
    int[] faceVertexCounts = [4, 4, 4, 4, 4, 4]
    int[] faceVertexIndices = [0,3,2,1, 4,5,6,7, 0,1,5,4, 1,2,6,5, 2,3,7,6, 3,0,4,7]
"""
TURNED_BOX = QUAD_BOX.replace("0,3,2,1, 4,5,6,7, 0,1,5,4, 1,2,6,5, 2,3,7,6, 3,0,4,7",
                              "0,1,2,3, 7,6,5,4, 4,5,1,0, 5,6,2,1, 6,7,3,2, 7,4,0,3")  # fmt: skip


def signed_volume(mesh: Mesh) -> float:
    """Positive if the faces are counter-clockwise from outside."""
    return float(np.linalg.det(mesh.points[mesh.faces]).sum() / 6)


@pytest.mark.parametrize(
    "text",
    [
        QUAD_BOX,
        TURNED_BOX + 'uniform token orientation = "leftHanded"',
        QUAD_BOX + 'double3 xformOp:scale = (-1, 1, 1) uniform token[] xformOpOrder = ["xformOp:scale"]',
    ],
)
def test_faces_point_outwards(text: str) -> None:
    mesh = only(f'def Mesh "x" {{ {text} }}').geoms[0].shape
    assert isinstance(mesh, Mesh)
    assert mesh.points.shape == (8, 3), "the point that no face uses is dropped"
    assert_allclose(signed_volume(mesh), 1)
    assert_allclose(mesh.volume, 1)


def test_texture_coordinates_of_corners_split_points() -> None:
    st = "[" + "(0,0),(1,0),(1,1),(0,1)," * 6 + "]"
    primvar = f'texCoord2f[] primvars:st = {st} (interpolation = "faceVarying")'
    mesh = only(f'def Mesh "x" {{ {QUAD_BOX} {primvar} }}').geoms[0].shape
    assert isinstance(mesh, Mesh)
    assert mesh.st is not None
    assert mesh.st.shape == (len(mesh.points), 2)
    assert_allclose(signed_volume(mesh), 1)
    corners = mesh.st[mesh.faces]
    assert {tuple(c) for c in corners.reshape(-1, 2).tolist()} == {(0, 0), (1, 0), (1, 1), (0, 1)}
    assert_allclose(corners[0], [(0, 0), (1, 0), (1, 1)])


def test_subsets_are_drawn_and_the_whole_collides() -> None:
    subset = """
    def GeomSubset "lid" (prepend apiSchemas = ["MaterialBindingAPI"]) {
        uniform token elementType = "face" uniform token familyName = "materialBind" int[] indices = [1]
        rel material:binding = </World/red> }"""
    red = """def Material "red" { token outputs:surface.connect = </World/red/s.outputs:surface>
        def Shader "s" { uniform token info:id = "UsdPreviewSurface" color3f inputs:diffuseColor = (1, 0, 0)
            token outputs:surface } }"""
    mesh = f'def Mesh "x" (prepend apiSchemas = ["PhysicsCollisionAPI"]) {{ {QUAD_BOX} {subset} }}'
    rest, lid, whole = only(mesh + red).geoms
    assert [(g.name, g.visible, g.collides) for g in (rest, lid, whole)] == [
        ("x_x", True, False),
        ("x_lid", True, False),
        ("x", False, True),
    ]
    assert_allclose(lid.surface.color, (1, 0, 0), atol=1e-6)
    assert isinstance(lid.shape, Mesh)
    assert isinstance(rest.shape, Mesh)
    assert (len(lid.shape.faces), len(rest.shape.faces)) == (2, 10)


def test_a_plane_is_the_top_of_a_big_box() -> None:
    plane = """def Plane "x" (prepend apiSchemas = ["PhysicsCollisionAPI"]) { uniform token axis = "Y"
        double3 xformOp:translate = (0, 3, 0) uniform token[] xformOpOrder = ["xformOp:translate"] }"""
    body = only(plane)
    (geom,) = body.geoms
    assert isinstance(geom.shape, Box)
    top = body.pose.position + geom.pose.position + rotation(geom.pose.orientation) @ (0, 0, geom.shape.half[2])
    assert_allclose(top, (0, 3, 0), atol=1e-12)


# ---------------------------------------------------------------- bodies


def test_velocities_are_in_the_space_of_the_parent() -> None:
    ball = BALL % "vector3f physics:velocity = (1, 0, 0) vector3f physics:angularVelocity = (180, 0, 0)"
    turned = f"""def Xform "turned" {{ float xformOp:rotateZ = 90 double3 xformOp:scale = (2, 2, 2)
        uniform token[] xformOpOrder = ["xformOp:rotateZ", "xformOp:scale"] {ball} }}"""
    body = only(turned)
    assert_allclose(body.linear_velocity, (0, 2, 0), atol=1e-12)
    assert_allclose(body.angular_velocity, (0, math.pi, 0), atol=1e-12)
    assert_same(body.geoms[0].shape, Sphere(0.2))


def test_instances_are_bodies_of_their_own() -> None:
    proto = 'class "proto" { def Sphere "s" (prepend apiSchemas = ["PhysicsCollisionAPI"]) { double radius = 0.1 } }'
    copies = "".join(
        f"""def Xform "{name}" (instanceable = true prepend apiSchemas = ["PhysicsRigidBodyAPI"]
            prepend inherits = </World/proto>) {{ double3 xformOp:translate = ({x}, 0, 0)
            uniform token[] xformOpOrder = ["xformOp:translate"] }}"""
        for x, name in enumerate("abc")
    )
    bodies = read(stage(proto + copies)).bodies
    assert [(b.name, b.pose.position[0], b.geoms[0].name) for b in bodies] == [
        ("a", 0, "s"),
        ("b", 1, "s"),
        ("c", 2, "s"),
    ]


def test_a_body_below_a_body_is_one_of_its_own() -> None:
    inside = f'def Cube "c" {COLLIDER} {{}} {BALL % ""}'
    outer = f'def Xform "o" (prepend apiSchemas = ["PhysicsRigidBodyAPI"]) {{ {inside} }}'
    bodies = read(stage(outer)).bodies
    assert [(b.name, [g.name for g in b.geoms]) for b in bodies] == [("o", ["c"]), ("ball", ["ball"])]
    assert_allclose(bodies[1].pose.position, (0, 0, 1))


def test_static_geometry_anywhere_and_names_that_clash() -> None:
    wall = 'def Cube "wall" (prepend apiSchemas = ["PhysicsCollisionAPI"]) {}'
    text = f"""{wall} def Xform "room" {{ {wall} }}
        def Xform "shelf" (kind = "component") {{ def Cube "left" {{}} def Xform "in" {{ def Cube "right" {{}} }} }}"""
    bodies = read(stage(text)).bodies
    assert [(b.name, b.path) for b in bodies] == [
        ("wall", "/World/wall"),
        ("World_room_wall", "/World/room/wall"),
        ("shelf", "/World/shelf"),
    ]
    assert [g.name for g in bodies[2].geoms] == ["left", "in_right"]
    assert all(b.motion == "static" and b.inertia is None for b in bodies)


def test_invisible_prims_are_not_drawn() -> None:
    text = """def Xform "a" { token visibility = "invisible" def Cube "decoration" {}
            def Cube "collider" (prepend apiSchemas = ["PhysicsCollisionAPI"]) {} }
        def Xform "b" { uniform token purpose = "guide" def Cube "hint" {} }"""
    (body,) = read(stage(text)).bodies
    assert (body.name, body.geoms[0].visible, body.geoms[0].collides) == ("collider", False, True)


def test_materials_are_inherited_and_may_come_from_one_material() -> None:
    both = """def Material "both" (prepend apiSchemas = ["PhysicsMaterialAPI"]) { float physics:staticFriction = 0.25
        color3f inputs:tint = (0, 1, 0) token outputs:surface.connect = </World/both/s.outputs:surface>
        def Shader "s" { uniform token info:id = "UsdPreviewSurface" token outputs:surface
            color3f inputs:diffuseColor.connect = </World/both.inputs:tint> } }"""
    bound = f"""def Xform "a" (prepend apiSchemas = ["MaterialBindingAPI"]) {{ rel material:binding = </World/both>
        {BALL % ""} }}"""
    (geom,) = only(both + bound).geoms
    assert_same(geom.friction, Friction(0.25, 0.25, 0.0))
    assert_allclose(geom.surface.color, (0, 1, 0), atol=1e-6)


def test_display_color_is_linear() -> None:
    body = only('def Cube "x" { color3f[] primvars:displayColor = [(0.2140411, 0, 1)] }')
    assert_allclose(body.geoms[0].surface.color, (0.5, 0, 1), atol=1e-6)


# ---------------------------------------------------------------- masses

MASSES = {
    "nothing": ("", "", ""),
    "body mass": ("float physics:mass = 3", "", ""),
    "body density": ("float physics:density = 500", "", ""),
    "collider beats body density": ("float physics:density = 500", "float physics:density = 100", ""),
    "one mass, one density": ("float physics:density = 500", "float physics:mass = 7", ""),
    "body mass beats colliders": ("float physics:mass = 3", "float physics:mass = 7", "float physics:density = 9"),
    "center": ("point3f physics:centerOfMass = (0.1, 0.2, 0.3)", "", ""),
    "inertia": ("float3 physics:diagonalInertia = (3, 4, 5) quatf physics:principalAxes = (1, 0, 0, 0)", "", ""),
    "all": (
        """float physics:mass = 3 float3 physics:diagonalInertia = (3, 4, 5) point3f physics:centerOfMass = (0, 0, 1)
        quatf physics:principalAxes = (0.8, 0.6, 0, 0)""",
        "",
        "",
    ),
    "collider inertia": ("", "float physics:mass = 7 float3 physics:diagonalInertia = (3, 4, 5)", ""),
}


@pytest.mark.parametrize("case", MASSES)
def test_masses_are_what_usd_computes(case: str) -> None:
    """The oracle is UsdPhysics' own `ComputeMassProperties`, which is given the shapes' volumes and tensors."""
    body, first, second = MASSES[case]
    apis = '(prepend apiSchemas = ["PhysicsCollisionAPI", "PhysicsMassAPI"])'
    opened = stage(f"""def Xform "b" (prepend apiSchemas = ["PhysicsRigidBodyAPI", "PhysicsMassAPI"]) {{ {body}
        def Cube "one" {apis} {{ double size = 0.5 {first} double3 xformOp:translate = (1, 0.5, 0)
            uniform token[] xformOpOrder = ["xformOp:translate"] }}
        def Sphere "two" {apis} {{ double radius = 0.4 {second} }} }}""")

    def shape_of(prim: Usd.Prim) -> UsdPhysics.RigidBodyAPI.MassInformation:
        info = UsdPhysics.RigidBodyAPI.MassInformation()
        cube = prim.GetName() == "one"
        info.volume = 0.5**3 if cube else 4 / 3 * math.pi * 0.4**3
        moment = info.volume * (0.5**2 / 6 if cube else 0.4 * 0.4**2)
        info.inertia.SetDiagonal(moment)
        if cube:
            info.localPos = Gf.Vec3f(1, 0.5, 0)
        return info

    api = UsdPhysics.RigidBodyAPI(opened.GetPrimAtPath("/World/b"))
    mass, moments, center, axes = api.ComputeMassProperties(shape_of)
    (found,) = (b.inertia for b in read(opened).bodies)
    assert found is not None
    turn, theirs = rotation(found.axes), rotation(np.array((axes.real, *axes.imaginary)))
    assert_allclose(found.mass, mass, rtol=1e-5)
    assert_allclose(found.center, center, atol=1e-5)
    tensor = theirs @ np.diag(moments) @ theirs.T
    assert_allclose(turn @ np.diag(found.moments) @ turn.T, tensor, rtol=1e-4, atol=1e-4 * np.abs(tensor).max())


def test_material_density_is_the_weakest() -> None:
    material = 'def Material "m" (prepend apiSchemas = ["PhysicsMaterialAPI"]) { float physics:density = 10 }'
    cube = """def Cube "x" (
        prepend apiSchemas = ["PhysicsRigidBodyAPI", "PhysicsCollisionAPI", "MaterialBindingAPI"%s]) {
        double size = 1 rel material:binding:physics = </World/m> %s }"""
    for more, expected in {("", ""): 10, (', "PhysicsMassAPI"', "float physics:density = 20"): 20}.items():
        inertia = only(material + cube % more).inertia
        assert inertia is not None
        assert_allclose(inertia.mass, expected)


# ---------------------------------------------------------------- stages without an episode, eyes or lights


def test_a_stage_without_episode_camera_and_light() -> None:
    scene = read(stage(BALL % ""))
    assert (scene.duration, scene.actions, scene.observations) == (0, (), ())
    assert_allclose(scene.gravity, (0, 0, -9.81))
    (camera,) = scene.cameras
    toward = rotation(camera.pose.orientation) @ (0, 0, -1)
    assert_allclose(np.cross(toward, scene.bodies[0].pose.position - camera.pose.position), 0, atol=1e-9)
    assert scene.light.diffuse + scene.light.ambient == 1
    assert replace(scene, duration=1.5).duration == 1.5


def test_foreign_intensities_keep_the_default_split() -> None:
    light = read(stage('def DistantLight "l" {float inputs:intensity = 3000}' + BALL % "")).light
    assert_allclose(light.direction, (0, 0, -1))
    assert (light.diffuse, light.ambient) == (0.4, 0.6)


# ---------------------------------------------------------------- what is refused

RIGID = '["PhysicsRigidBodyAPI", '
COLLIDER = '(prepend apiSchemas = ["PhysicsCollisionAPI"])'
ACTION = 'def WmsAction "a" { uniform token wms:verb = "%s" rel wms:object = </World/%s> %s }'
PREVIEW = """def Cube "x" (prepend apiSchemas = ["MaterialBindingAPI"]) { rel material:binding = </World/m> }
    def Material "m" { token outputs:surface.connect = </World/m/s.outputs:surface>
        def Shader "s" { uniform token info:id = "%s" token outputs:surface %s } }"""

REFUSED = {
    "joint": ('def PhysicsDistanceJoint "j" {}', "j", "distance joints"),
    "points": ('def Points "p" {}', "p", "geometry"),
    "instancer": ('def PointInstancer "p" {}', "p", "instancers"),
    "particles": ('def Cube "a" (prepend apiSchemas = ["PhysxParticleClothAPI"]) {}', "a", "particles"),
    "sdf": ('def Cube "a" (prepend apiSchemas = ["PhysxSDFMeshCollisionAPI"]) {}', "a", "signed distance"),
    "animated": (
        """def Cube "a" { double3 xformOp:translate.timeSamples = {0: (0, 0, 0), 1: (1, 0, 0)}
        uniform token[] xformOpOrder = ["xformOp:translate"] }""",
        "a",
        "animated",
    ),
    "animated size": (
        BALL.replace("double radius = 0.1", "double radius.timeSamples = {0: 1, 9: 2}") % "",
        "ball",
        "radius is",
    ),
    "animated gravity": (
        'def PhysicsScene "s" {float physics:gravityMagnitude.timeSamples = {0: 0, 24: 9.81}}',
        "s",
        "physics:gravityMagnitude is animated",
    ),
    "animated points": (
        'def Mesh "a" {point3f[] points.timeSamples = {0: [(0, 0, 0)], 1: [(1, 0, 0)]}}',
        "a",
        "points is animated",
    ),
    "animated subset": (
        f"""def Mesh "a" {{ {QUAD_BOX} def GeomSubset "lid" {{ uniform token familyName = "materialBind"
        int[] indices.timeSamples = {{0: [0], 1: [1]}} }} }}""",
        "a/lid",
        "indices is animated",
    ),
    "animated texture coordinates": (
        f"""def Mesh "a" {{ {QUAD_BOX}
        texCoord2f[] primvars:st.timeSamples = {{0: [(0, 0)], 1: [(1, 0)]}} }}""",
        "a",
        "primvars:st is animated",
    ),
    "animated display colour": (
        'def Cube "a" {color3f[] primvars:displayColor.timeSamples = {0: [(0, 0, 0)], 1: [(1, 0, 0)]}}',
        "a",
        "primvars:displayColor is animated",
    ),
    "animated colour": (
        PREVIEW % ("UsdPreviewSurface", "color3f inputs:diffuseColor.timeSamples = {0: (0, 0, 0), 1: (1, 0, 0)}"),
        "m/s",
        "inputs:diffuseColor is animated",
    ),
    "velocity without end": (
        BALL % "vector3f physics:velocity = (inf, 0, 0)",
        "ball",
        "physics:velocity = (inf, 0, 0) is",
    ),
    "centre of mass": (BALL % "point3f physics:centerOfMass = (nan, 0, 0)", "ball", "physics:centerOfMass = (nan"),
    "half a centre of mass": (
        BALL % "point3f physics:centerOfMass = (-inf, 0, 0)",
        "ball",
        "physics:centerOfMass = (-inf",
    ),
    "axes": (
        BALL % "quatf physics:principalAxes = (nan, 0, 0, 0) float3 physics:diagonalInertia = (1, 1, 1)",
        "ball",
        "physics:principalAxes = (nan",
    ),
    "damping": (BALL % "float physxRigidBody:linearDamping = nan", "ball", "physxRigidBody:linearDamping = nan"),
    "gravity's direction": (
        'def PhysicsScene "s" {vector3f physics:gravityDirection = (nan, 0, -1)}',
        "s",
        "physics:gravityD",
    ),
    "gravity without end": (
        'def PhysicsScene "s" {float physics:gravityMagnitude = inf}',
        "s",
        "physics:gravityMagnitude",
    ),
    "place": ((BALL % "").replace("(0, 0, 1)", "(nan, 0, 1)"), "ball", "xformOp:translate = (nan, 0, 1) is not finite"),
    "place above": (
        f"""def Xform "a" {{ float xformOp:rotateZ = inf uniform token[] xformOpOrder = ["xformOp:rotateZ"]
        {BALL % ""} def Cube "c" {{}} }}""",
        "a",
        "xformOp:rotateZ = inf",
    ),
    "place that is not there": (
        f"""def Xform "a" {{ uniform token[] xformOpOrder = ["xformOp:translate"]
        {BALL % ""} def Cube "c" {{}} }}""",
        "a",
        "its xformOpOrder names xformOp:translate, which it does not have",
    ),
    "points without number": (
        f'def Mesh "a" {{ {QUAD_BOX.replace("(9,9,9)", "(nan,9,9)")} }}',
        "a",
        "one of points is not finite",
    ),
    "far": ('def Camera "c" {float2 clippingRange = (1, inf)}', "c", "clippingRange = (1, inf)"),
    "reference": (
        'def Xform "a" (prepend references = @none.usda@</T>) {} def Xform "b" {}',
        "a",
        "Could not open asset @none.usda@ for reference",
    ),
    "payload": (
        'def Xform "a" (prepend payload = @none.usda@) {}',
        "a",
        "Could not open asset @none.usda@ for payload",
    ),
    "filtered pair": (
        (BALL % "rel physics:filteredPairs = </World/bell>").replace('["', '["PhysicsFilteredPairsAPI", "', 1),
        "ball",
        "physics:filteredPairs -> /World/bell is not on the stage",
    ),
    "collision group": (
        """def PhysicsCollisionGroup "g" (prepend apiSchemas = ["CollectionAPI:colliders"]) {
        rel collection:colliders:includes = </World/bell> }""",
        "g",
        "collection:colliders:includes -> /World/bell",
    ),
    "filtered group": (
        'def PhysicsCollisionGroup "g" {rel physics:filteredGroups = </World/h>}',
        "g",
        "physics:filteredGroups -> /World/h is not on the stage",
    ),
    "binding": (
        'def Xform "a" (prepend apiSchemas = ["MaterialBindingAPI"]) { rel material:binding:physics = </World/m> }',
        "a",
        "material:binding:physics -> /World/m is not on the stage",
    ),
    "binding of a subset": (
        f"""def Mesh "a" {{ {QUAD_BOX}
        def GeomSubset "lid" {{ int[] indices = [1] rel material:binding = </World/m> }} }}""",
        "a/lid",
        "material:binding -> /World/m is not on the stage",
    ),
    "asleep": (BALL % "uniform bool physics:startsAsleep = 1", "ball", "asleep"),
    "no shape": (f'def Xform "a" {COLLIDER} {{}}', "a", "no shape"),
    "no mass": ('def Xform "a" (prepend apiSchemas = ["PhysicsRigidBodyAPI"]) {}', "a", "no mass"),
    "negative mass": ((BALL % "").replace("mass = 2", "mass = -2"), "ball", "physics:mass = -2"),
    "radius": ((BALL % "").replace("radius = 0.1", "radius = 0"), "ball", "radius = 0"),
    "ellipsoid": (
        'def Sphere "a" {double3 xformOp:scale = (1, 1, 2) uniform token[] xformOpOrder = ["xformOp:scale"]}',
        "a",
        "elliptic",
    ),
    "sheared": (
        """def Xform "a" { double3 xformOp:scale = (1, 2, 1) uniform token[] xformOpOrder = ["xformOp:scale"]
        def Cube "b" {float xformOp:rotateZ = 30 uniform token[] xformOpOrder = ["xformOp:rotateZ"]} }""",
        "a/b",
        "shears",
    ),
    "flat": (
        'def Cube "a" {double3 xformOp:scale = (1, 0, 1) uniform token[] xformOpOrder = ["xformOp:scale"]}',
        "a",
        "zero",
    ),
    "indices": ('def Mesh "a" {int[] faceVertexCounts = [3] int[] faceVertexIndices = [0, 1, 2]}', "a", "do not fit"),
    "flat collider": (
        f"""def Mesh "a" {COLLIDER.replace("[", RIGID)} {{
        int[] faceVertexCounts = [3] int[] faceVertexIndices = [0, 1, 2]
        point3f[] points = [(0, 0, 0), (1, 0, 0), (0, 1, 0)]}}""",
        "a",
        "dynamic mesh that collides has no volume",
    ),
    "collider on a line": (
        f"""def Mesh "a" {COLLIDER} {{int[] faceVertexCounts = [3] int[] faceVertexIndices = [0, 1, 2]
        point3f[] points = [(0, 0, 0), (1, 0, 0), (2, 0, 0)]}}""",
        "a",
        "on a line",
    ),
    "hollow collider": (
        f'def Mesh "a" {COLLIDER.replace("[", RIGID)} {{ {QUAD_BOX.replace("(1,1,1)", "(.3,.3,.3)")} }}',
        "a",
        "non-convex",
    ),
    "friction": (
        """def Material "m" (prepend apiSchemas = ["PhysicsMaterialAPI"]) {float physics:restitution = 1.5}
        def Cube "a" (prepend apiSchemas = ["MaterialBindingAPI", "PhysicsCollisionAPI"]) {
            rel material:binding:physics = </World/m>}""",
        "m",
        "restitution = 1.5",
    ),
    "shader": (PREVIEW % ("ND_standard_surface_surfaceshader", ""), "m/s", "not a UsdPreviewSurface"),
    "transparent": (PREVIEW % ("UsdPreviewSurface", "float inputs:opacity = 0.5"), "m/s", "transparency"),
    "orthographic": ('def Camera "c" {token projection = "orthographic"}', "c", "perspective"),
    "lamp": ('def SphereLight "l" {}', "l", "DistantLight"),
    "two suns": ('def DistantLight "k" {} def DistantLight "l" {}', "l", "only one"),
    "two scenes": ('def PhysicsScene "k" {} def PhysicsScene "l" {}', "l", "only one"),
    "verb": (BALL % "" + ACTION % ("explode", "ball", ""), "a", "'explode' is unknown"),
    "wrong motion": (BALL % "" + ACTION % ("glide", "ball", ""), "a", "kinematic body"),
    "no object": (BALL % "" + ACTION % ("launch", "bell", ""), "a", "rigid body"),
    "direction": (
        BALL % ""
        + ACTION % ("launch", "ball", "uniform double wms:speed = 1 uniform double3 wms:direction = (1, 1, 0)"),
        "a",
        "no unit vector",
    ),
    "newer": ('def WmsEpisode "e" {uniform int wms:formatVersion = 99}', "e", "newer"),
    "kinematic velocity": (
        BALL % "bool physics:kinematicEnabled = 1 vector3f physics:velocity = (1, 0, 0)",
        "ball",
        "kinematic",
    ),
}


@pytest.mark.parametrize("case", REFUSED)
def test_unsupported_input_is_refused(case: str) -> None:
    text, path, reason = REFUSED[case]
    ((where, why),) = problems(text).items()
    assert where == f"/World/{path}"
    assert reason in why


def test_layers_that_are_not_there(tmp_path: Path) -> None:
    path = tmp_path / "a.usda"
    path.write_text("#usda 1.0\n(\n    subLayers = [@none.usda@]\n)\n" + lines(BALL % ""))
    with pytest.raises(StageError, match=r"/: Could not load sublayer .*none\.usda"):
        read(Usd.Stage.Open(str(path)))


@pytest.mark.parametrize("unit", ["meters", "kilograms"])
@pytest.mark.parametrize("number", [0, -1, math.nan, math.inf])
def test_units_are_above_0(unit: str, number: float) -> None:
    with pytest.raises(StageError) as caught:
        read(stage(BALL % "" + REFUSED["joint"][0], **{unit: number}))  # type: ignore[arg-type]
    reported = [(str(problem.place), problem.message) for problem in caught.value.diagnostics]
    assert reported == [("/", f"{unit}PerUnit = {number:g}"), ("/World/j", "distance joints are not supported")]


def test_infinite_values_mean_unset() -> None:
    ball = BALL % "point3f physics:centerOfMass = (-inf, -inf, -inf)"
    scene = read(stage(ball + 'def PhysicsScene "s" {float physics:gravityMagnitude = -inf}'))
    assert_allclose(scene.gravity, (0, 0, -9.81))
    assert scene.bodies[0].inertia is not None
    assert_allclose(scene.bodies[0].inertia.center, 0)


SLIPPERY = """def Material "ice" (prepend apiSchemas = ["PhysicsMaterialAPI"]) { %s }
    def Mesh "a" (prepend apiSchemas = ["PhysicsCollisionAPI", "MaterialBindingAPI"]) { %s %s
        def GeomSubset "lid" (prepend apiSchemas = ["MaterialBindingAPI"]) { uniform token elementType = "face"
            uniform token familyName = "materialBind"
            int[] indices = [1]
            rel material:binding:physics = </World/ice> } }"""
ICE = "float physics:staticFriction = 0.1"


def test_subset_has_the_friction_of_its_mesh() -> None:
    (found,) = problems(SLIPPERY % (ICE, "", QUAD_BOX)).items()
    assert found[0] == "/World/a/lid"
    assert "physics material /World/ice differs from that of its mesh" in found[1]
    assert (
        "differs from that of its mesh"
        in problems(SLIPPERY % ("float physics:density = 9", "", QUAD_BOX))["/World/a/lid"]
    )
    same = only(SLIPPERY % (ICE, "rel material:binding:physics = </World/ice>", QUAD_BOX))
    assert all(geom.friction.dynamic == pytest.approx(0.1) for geom in same.geoms)
    only(SLIPPERY % (ICE, "bool physics:collisionEnabled = 0", QUAD_BOX))
    only((SLIPPERY % (ICE, "", QUAD_BOX)).replace("binding:physics", "binding:preview"))


def test_all_problems_are_reported_at_once() -> None:
    cases = ("joint", "points", "animated", "transparent", "newer")
    texts = [f'def Scope "{case}" {{ {REFUSED[case][0]} }}' for case in cases]
    texts[3] = texts[3].replace("/World/m", "/World/transparent/m")
    assert sorted(problems("".join(texts))) == sorted(f"/World/{case}/{REFUSED[case][1]}" for case in cases)


def test_a_stage_error_survives_a_process_border() -> None:
    with pytest.raises(StageError) as caught:
        read(stage(REFUSED["joint"][0]))
    again = pickle.loads(pickle.dumps(caught.value))
    assert (str(again), again.diagnostics) == (str(caught.value), caught.value.diagnostics)
    assert str(again).startswith("/World/j: distance joints are not supported; ")


# ---------------------------------------------------------------- belts

BELT = """
def Cube "belt" (prepend apiSchemas = ["PhysicsRigidBodyAPI", "PhysicsCollisionAPI", "PhysxSurfaceVelocityAPI"]) {
    double size = 0.1
    double3 xformOp:rotateXYZ = (0, 0, 90)
    uniform token[] xformOpOrder = ["xformOp:rotateXYZ"]
    bool physics:kinematicEnabled = %s
    vector3f physxSurfaceVelocity:surfaceVelocity = (0.2, 0, 0)
    %s
}"""


@pytest.mark.parametrize(
    ("more", "expected"),
    [
        ("", (0.2, 0, 0)),
        ("bool physxSurfaceVelocity:surfaceVelocityLocalSpace = false", (0, -0.2, 0)),
        ("bool physxSurfaceVelocity:surfaceVelocityEnabled = false", (0, 0, 0)),
    ],
)
def test_the_surface_velocity_of_a_belt_is_along_its_own_axes_or_those_of_the_world(
    more: str, expected: tuple[float, ...]
) -> None:
    assert_allclose(only(BELT % ("true", more)).surface_velocity, expected, atol=1e-6)
    slower = only(BELT % ("true", more), meters=0.01).surface_velocity
    assert_allclose(slower, np.array(expected) / 100, atol=1e-8)


def test_other_surfaces_that_move_are_refused() -> None:
    assert problems(BELT % ("false", "")) == {"/World/belt": "a surface velocity of a dynamic body is not supported"}
    turning = "vector3f physxSurfaceVelocity:surfaceAngularVelocity = (0, 0, 30)"
    assert problems(BELT % ("true", turning)) == {"/World/belt": "a surface that turns is not supported"}
