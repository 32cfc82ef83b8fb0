"""Stages as text: plain UsdPhysics, one prim for a body with its one geometry below it."""

from __future__ import annotations

from collections.abc import Sequence
from math import cos, degrees, pi, sin

from wmspec.core.space import Vector

G = 9.81
ORIGIN: Vector = (0.0, 0.0, 0.0)
UPRIGHT = (1.0, 0.0, 0.0, 0.0)


def stage(
    *prims: str, friction: float | tuple[float, float] = 0.5, restitution: float = 0.0, gravity: float = G
) -> str:
    """A stage of prims that are all of one material: then every rule of mixing materials gives the same."""
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
    at: Vector = ORIGIN,
    turn: Sequence[float] = UPRIGHT,
    *,
    mass: float | None = 1.0,
    velocity: Vector = ORIGIN,
    spin: Vector = ORIGIN,
    moments: Vector | None = None,
    more: str = "",
    apis: Sequence[str] = (),
) -> str:
    """A rigid body of a `shape`; one without a mass never moves. `spin` in rad/s."""
    moving = mass is not None
    schemas = [*(["PhysicsRigidBodyAPI", "PhysicsMassAPI"] if moving else []), *apis]
    own = (
        f"""        vector3f physics:velocity = {velocity}
        vector3f physics:angularVelocity = {tuple(degrees(w) for w in spin)}
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
{own}{more}        double3 xformOp:translate = {at}
        quatd xformOp:orient = {tuple(turn)}
        uniform token[] xformOpOrder = ["xformOp:translate", "xformOp:orient"]

        def {shape}
    }}

"""


_TOUCHED = '(prepend apiSchemas = ["PhysicsCollisionAPI", "MaterialBindingAPI"])'
_BOUND = "rel material:binding:physics = </World/material>"


def box(x: float, y: float, z: float) -> str:
    """A box of these edges."""
    return f"""Cube "shape" {_TOUCHED}
        {{
            {_BOUND}
            double size = 1
            float3[] extent = [(-0.5, -0.5, -0.5), (0.5, 0.5, 0.5)]
            double3 xformOp:scale = {(x, y, z)}
            uniform token[] xformOpOrder = ["xformOp:scale"]
        }}"""


def ball(radius: float) -> str:
    """A ball."""
    return f"""Sphere "shape" {_TOUCHED}
        {{
            {_BOUND}
            double radius = {radius}
            float3[] extent = [({-radius}, {-radius}, {-radius}), ({radius}, {radius}, {radius})]
        }}"""


def cylinder(radius: float, height: float, axis: str = "Z") -> str:
    """A cylinder along an axis."""
    half = [radius] * 3
    half["XYZ".index(axis)] = height / 2
    x, y, z = half
    return f"""Cylinder "shape" {_TOUCHED}
        {{
            {_BOUND}
            double radius = {radius}
            double height = {height}
            uniform token axis = "{axis}"
            float3[] extent = [({-x}, {-y}, {-z}), ({x}, {y}, {z})]
        }}"""


def prism(sides: int, radius: float, height: float) -> str:
    """A prism over a regular polygon, as the mesh of its convex hull."""
    ring = [(radius * cos(2 * pi * i / sides), radius * sin(2 * pi * i / sides)) for i in range(sides)]
    points = [(x, y, z) for z in (-height / 2, height / 2) for x, y in ring]
    sheets = [[i, (i + 1) % sides, sides + (i + 1) % sides, sides + i] for i in range(sides)]
    faces = [[*reversed(range(sides))], [*range(sides, 2 * sides)], *sheets]
    half = radius, radius, height / 2
    return f"""Mesh "shape" (
            prepend apiSchemas = ["PhysicsCollisionAPI", "PhysicsMeshCollisionAPI", "MaterialBindingAPI"]
        )
        {{
            {_BOUND}
            uniform token physics:approximation = "convexHull"
            point3f[] points = {points}
            int[] faceVertexCounts = {[len(face) for face in faces]}
            int[] faceVertexIndices = {[corner for face in faces for corner in face]}
            float3[] extent = [{tuple(-x for x in half)}, {half}]
            uniform token subdivisionScheme = "none"
        }}"""


def floor(turn: Sequence[float] = UPRIGHT) -> str:
    """A slab of 1 m whose top goes through the origin."""
    from wmspec.sim.scene.model.transform import rotate

    x, y, z = rotate([*turn], [0.0, 0.0, -0.5]).tolist()  # type: ignore[arg-type]
    return body("floor", box(40.0, 40.0, 1.0), (x, y, z), turn, mass=None)


def joint(
    kind: str,
    name: str,
    first: str,
    second: str,
    above: Vector = ORIGIN,
    below: Vector = ORIGIN,
    axis: str = "X",
    *,
    limits: tuple[float, float] | None = None,
    drive: str = "",
    mimic: tuple[str, float, float] | None = None,
    physx: bool = False,
) -> str:
    """A joint between two bodies, or a body and the world (an empty name), by its places in them; limits are as in USD.

    `drive`: the attributes of its drive after `drive:NAME:physics:`, each on a line. `mimic`: the joint that it mimics,
    c0 and c1, as Newton's schema has them, or as that of `physx`.
    """
    way = "angular" if kind == "Revolute" else "linear"
    apis = [f"PhysicsDriveAPI:{way}"] if drive else []
    apis += (["PhysxMimicJointAPI:rotX"] if physx else ["NewtonMimicAPI"]) if mimic else []
    schemas = " (prepend apiSchemas = [" + ", ".join(f'"{api}"' for api in apis) + "])" if apis else ""
    lines = [f"rel physics:body{i} = </World/{name}>" for i, name in enumerate((first, second)) if name]
    lines += [f"point3f physics:localPos0 = {above}", f"point3f physics:localPos1 = {below}"]
    lines += ["quatf physics:localRot0 = (1, 0, 0, 0)", "quatf physics:localRot1 = (1, 0, 0, 0)"]
    lines += [f'uniform token physics:axis = "{axis}"'] if kind in ("Revolute", "Prismatic") else []
    lines += [f"float physics:{end}Limit = {v}" for end, v in zip(("lower", "upper"), limits or (), strict=False)]
    lines += [f"float drive:{way}:physics:{line}" for line in drive.splitlines()]
    if mimic and physx:
        lines += [f"rel physxMimicJoint:rotX:referenceJoint = </World/{mimic[0]}>"]
        lines += [
            f"float physxMimicJoint:rotX:{what} = {-v}"
            for what, v in zip(("offset", "gearing"), mimic[1:], strict=True)
        ]
    elif mimic:
        lines += [f"rel newton:mimicJoint = </World/{mimic[0]}>"]
        lines += [f"float newton:mimicCoef{i} = {v}" for i, v in enumerate(mimic[1:])]
    told = "\n".join(f"        {line}" for line in lines)
    return f'    def Physics{kind}Joint "{name}"{schemas}\n    {{\n{told}\n    }}\n\n'
