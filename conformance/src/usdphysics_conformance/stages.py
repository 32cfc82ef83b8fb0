"""Stages as text: plain UsdPhysics, a prim for each body with its one shape below it."""

from __future__ import annotations

from collections.abc import Sequence
from math import cos, degrees, pi, sin

from usdphysics_conformance.quaternions import rotate

Vector = tuple[float, float, float]

G = 9.81
"""The acceleration of gravity on every stage that has any, m/s²."""
ORIGIN: Vector = (0.0, 0.0, 0.0)
UPRIGHT = (1.0, 0.0, 0.0, 0.0)


def stage(
    *prims: str, friction: float | tuple[float, float] = 0.5, restitution: float = 0.0, gravity: float = G
) -> str:
    """The text of a stage. All shapes have one material, so that every rule for combining materials gives the same."""
    static, dynamic = friction if isinstance(friction, tuple) else (friction, friction)
    return f"""#usda 1.0
(
    defaultPrim = "World"
    metersPerUnit = 1
    kilogramsPerUnit = 1
    upAxis = "Z"
)

def Xform "World"
{{
    def PhysicsScene "physics"
    {{
        vector3f physics:gravityDirection = (0, 0, -1)
        float physics:gravityMagnitude = {gravity}
    }}

    def Material "material" (prepend apiSchemas = ["PhysicsMaterialAPI"])
    {{
        float physics:staticFriction = {static}
        float physics:dynamicFriction = {dynamic}
        float physics:restitution = {restitution}
    }}

{"".join(prims)}}}
"""


def body(
    name: str,
    shape: str,
    position: Vector = ORIGIN,
    orientation: Sequence[float] = UPRIGHT,
    *,
    mass: float | None = 1.0,
    velocity: Vector = ORIGIN,
    angular_velocity: Vector = ORIGIN,
    moments: Vector | None = None,
    attributes: str = "",
    apis: Sequence[str] = (),
) -> str:
    """A rigid body with a `shape`, or a static one if `mass` is None.

    `angular_velocity` in rad/s, `moments` of inertia in kg m². `attributes` and `apis` are added to the prim.
    """
    moving = mass is not None
    schemas = [*(["PhysicsRigidBodyAPI", "PhysicsMassAPI"] if moving else []), *apis]
    own = (
        f"""        vector3f physics:velocity = {velocity}
        vector3f physics:angularVelocity = {tuple(degrees(w) for w in angular_velocity)}
        float physics:mass = {mass}
"""
        if moving
        else ""
    )
    if moments:
        own += (
            f"        float3 physics:diagonalInertia = {moments}\n        quatf physics:principalAxes = (1, 0, 0, 0)\n"
        )
    listed = ", ".join(f'"{api}"' for api in schemas)
    head = f" (prepend apiSchemas = [{listed}])" if schemas else ""
    return f"""    def Xform "{name}"{head}
    {{
{own}{attributes}        double3 xformOp:translate = {position}
        quatd xformOp:orient = {tuple(orientation)}
        uniform token[] xformOpOrder = ["xformOp:translate", "xformOp:orient"]

        def {shape}
    }}

"""


_COLLIDES = '(prepend apiSchemas = ["PhysicsCollisionAPI", "MaterialBindingAPI"])'
_MATERIAL = "rel material:binding:physics = </World/material>"


def box(x: float, y: float, z: float) -> str:
    """A box with these edge lengths."""
    return f"""Cube "shape" {_COLLIDES}
        {{
            {_MATERIAL}
            double size = 1
            float3[] extent = [(-0.5, -0.5, -0.5), (0.5, 0.5, 0.5)]
            double3 xformOp:scale = {(x, y, z)}
            uniform token[] xformOpOrder = ["xformOp:scale"]
        }}"""


def ball(radius: float) -> str:
    """A sphere."""
    return f"""Sphere "shape" {_COLLIDES}
        {{
            {_MATERIAL}
            double radius = {radius}
            float3[] extent = [({-radius}, {-radius}, {-radius}), ({radius}, {radius}, {radius})]
        }}"""


def cylinder(radius: float, height: float, axis: str = "Z") -> str:
    """A cylinder along an axis."""
    half = [radius] * 3
    half["XYZ".index(axis)] = height / 2
    x, y, z = half
    return f"""Cylinder "shape" {_COLLIDES}
        {{
            {_MATERIAL}
            double radius = {radius}
            double height = {height}
            uniform token axis = "{axis}"
            float3[] extent = [({-x}, {-y}, {-z}), ({x}, {y}, {z})]
        }}"""


def prism(sides: int, radius: float, height: float) -> str:
    """A prism over a regular polygon, as a mesh that collides as its convex hull."""
    ring = [(radius * cos(2 * pi * i / sides), radius * sin(2 * pi * i / sides)) for i in range(sides)]
    points = [(x, y, z) for z in (-height / 2, height / 2) for x, y in ring]
    sheets = [[i, (i + 1) % sides, sides + (i + 1) % sides, sides + i] for i in range(sides)]
    faces = [[*reversed(range(sides))], [*range(sides, 2 * sides)], *sheets]
    half = radius, radius, height / 2
    return f"""Mesh "shape" (
            prepend apiSchemas = ["PhysicsCollisionAPI", "PhysicsMeshCollisionAPI", "MaterialBindingAPI"]
        )
        {{
            {_MATERIAL}
            uniform token physics:approximation = "convexHull"
            point3f[] points = {points}
            int[] faceVertexCounts = {[len(face) for face in faces]}
            int[] faceVertexIndices = {[corner for face in faces for corner in face]}
            float3[] extent = [{tuple(-x for x in half)}, {half}]
            uniform token subdivisionScheme = "none"
        }}"""


def floor(orientation: Sequence[float] = UPRIGHT) -> str:
    """A static slab, 1 m thick, whose top passes through the origin."""
    x, y, z = rotate(orientation, (0.0, 0.0, -0.5)).tolist()
    return body("floor", box(40.0, 40.0, 1.0), (x, y, z), orientation, mass=None)


def joint(
    kind: str,
    name: str,
    first: str,
    second: str,
    local_pos0: Vector = ORIGIN,
    local_pos1: Vector = ORIGIN,
    axis: str = "X",
    *,
    limits: tuple[float, float] | None = None,
    drive: str = "",
    mimic: tuple[str, float, float] | None = None,
    physx: bool = False,
) -> str:
    """A joint between two bodies, or between the world (an empty name) and a body; units of `limits` as in USD.

    `drive`: attributes of its drive without `drive:NAME:physics:`, one a line. `mimic`: the name of the joint that it
    mimics, c0 and c1, written in the schema of Newton, or in that of PhysX if `physx`.
    """
    drive_name = "angular" if kind == "Revolute" else "linear"
    apis = [f"PhysicsDriveAPI:{drive_name}"] if drive else []
    apis += (["PhysxMimicJointAPI:rotX"] if physx else ["NewtonMimicAPI"]) if mimic else []
    schemas = " (prepend apiSchemas = [" + ", ".join(f'"{api}"' for api in apis) + "])" if apis else ""
    lines = [f"rel physics:body{i} = </World/{name}>" for i, name in enumerate((first, second)) if name]
    lines += [f"point3f physics:localPos0 = {local_pos0}", f"point3f physics:localPos1 = {local_pos1}"]
    lines += ["quatf physics:localRot0 = (1, 0, 0, 0)", "quatf physics:localRot1 = (1, 0, 0, 0)"]
    lines += [f'uniform token physics:axis = "{axis}"'] if kind in ("Revolute", "Prismatic") else []
    lines += [f"float physics:{end}Limit = {v}" for end, v in zip(("lower", "upper"), limits or (), strict=False)]
    lines += [f"float drive:{drive_name}:physics:{line}" for line in drive.splitlines()]
    if mimic and physx:
        lines += [f"rel physxMimicJoint:rotX:referenceJoint = </World/{mimic[0]}>"]
        lines += [
            f"float physxMimicJoint:rotX:{what} = {-v}"
            for what, v in zip(("offset", "gearing"), mimic[1:], strict=True)
        ]
    elif mimic:
        lines += [f"rel newton:mimicJoint = </World/{mimic[0]}>"]
        lines += [f"float newton:mimicCoef{i} = {v}" for i, v in enumerate(mimic[1:])]
    body_text = "\n".join(f"        {line}" for line in lines)
    return f'    def Physics{kind}Joint "{name}"{schemas}\n    {{\n{body_text}\n    }}\n\n'
