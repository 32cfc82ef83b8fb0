"""Bodies of a scene: every rigid body of the stage, and every group of static geoms."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from pxr import Gf

from wmspec.core.diagnostics import Report, StageError
from wmspec.sim.scene.model import Array, Body, Geom, Inertia, Pose
from wmspec.sim.scene.model.transform import conjugate, rotate
from wmspec.sim.usd.colliders import DOWN, collision_shapes
from wmspec.sim.usd.frames import StageFrame, split_transform, vector
from wmspec.sim.usd.geoms import MaterialTable, geoms
from wmspec.sim.usd.masses import body_inertia, plausible_inertia
from wmspec.sim.usd.prims import Names, applied_schemas, refuse, value
from wmspec.sim.usd.shapes import PlacedShape, placed_shape
from wmspec.sim.usd.stage_index import BodyPrim
from wmspec.sim.usd.substitutions import STRICT, Substitutions

_BELT_SCHEMA, _BELT = "PhysxSurfaceVelocityAPI", "physxSurfaceVelocity:surface"


def bodies(
    owners: Sequence[BodyPrim], world: StageFrame, problems: Report, notes: Substitutions = STRICT
) -> tuple[Body, ...]:
    """Return the bodies in stage order; errors go to `problems`."""
    materials = MaterialTable((piece for owner in owners for piece in owner.pieces), notes=notes)
    names, read = Names(), []
    for owner in owners:
        name = names.give(owner.prim.GetName(), str(owner.prim.GetPath()))
        with problems.collect_errors():
            read.append(_body(owner, name, world, materials, notes))
    return tuple(read)


def _body(owner: BodyPrim, name: str, world: StageFrame, materials: MaterialTable, notes: Substitutions) -> Body:
    prim, path = owner.prim, str(owner.prim.GetPath())
    place = split_transform(world.matrix(prim), prim)
    inverse = place.rigid.GetInverse()
    down = rotate(conjugate(place.pose.orientation), DOWN)
    problems, names = Report(StageError), Names()
    pieces: list[Geom] = []
    colliders: list[tuple[PlacedShape, float]] = []
    for piece in owner.pieces:
        with problems.collect_errors():
            here = placed_shape(piece.prim, split_transform(world.matrix(piece.prim) * inverse, piece.prim), notes)
            below = str(piece.prim.GetPath()).removeprefix(path)
            touched = collision_shapes(here, owner.motion, down, notes) if piece.collides else ()
            pieces += geoms(piece, here, touched, names.give(below or prim.GetName()), names, materials)
            if piece.collides:
                colliders.append((here, materials.density(piece.prim)))
    problems.stop_if_failed()
    seen = [(geom.shape, geom.pose) for geom in pieces]
    inertia = None
    if owner.motion == "dynamic":
        inertia = body_inertia(prim, place, colliders, world, seen, notes)
        solid = [(geom.shape, geom.pose) for geom in pieces if geom.collides]
        drawn = [(geom.shape, geom.pose) for geom in pieces if geom.collides or geom.visible]
        inertia = plausible_inertia(prim, inertia, solid, drawn, notes)
    return body(owner, name, place.pose, tuple(pieces), inertia, world)


def body(
    owner: BodyPrim, name: str, pose: Pose, geoms: tuple[Geom, ...], inertia: Inertia | None, world: StageFrame
) -> Body:
    """Return a body with its velocities and damping.

    Raises: StageError: if it is kinematic with a velocity, or if its surface moves and it is not kinematic.
    """
    linear, angular = (float(value(owner.prim, f"physxRigidBody:{kind}Damping", 0.0)) for kind in ("linear", "angular"))
    path = str(owner.prim.GetPath())
    surface = _surface_velocity(owner, pose, world)
    return Body(name, path, owner.motion, pose, geoms, inertia, *_velocities(owner, world), linear, angular, surface)


def _velocities(owner: BodyPrim, world: StageFrame) -> tuple[Array, Array]:
    """Return linear (m/s) and angular (rad/s) velocity in world axes; USD gives them in the space of the prim's
    transform.
    """
    linear = Gf.Vec3d(value(owner.prim, "physics:velocity", Gf.Vec3f(0)))
    angular = Gf.Vec3d(value(owner.prim, "physics:angularVelocity", Gf.Vec3f(0)))
    if owner.motion == "static" or not (any(linear) or any(angular)):
        return np.zeros(3), np.zeros(3)
    if owner.motion == "kinematic":
        refuse(owner.prim, "a kinematic body with a velocity is not supported", "use a WmsAction with verb glide")
    parent = world.parent(owner.prim)
    turn = split_transform(parent, owner.prim).rigid
    return vector(parent.TransformDir(linear)), np.radians(vector(turn.TransformDir(angular)))


def _surface_velocity(owner: BodyPrim, pose: Pose, world: StageFrame) -> tuple[float, float, float]:
    """Return the velocity of the surface of a belt (m/s, axes of the body), as PhysxSurfaceVelocityAPI states it."""
    prim = owner.prim
    if _BELT_SCHEMA not in applied_schemas(prim) or not value(prim, f"{_BELT}VelocityEnabled", True):
        return (0.0, 0.0, 0.0)
    if any(value(prim, f"{_BELT}AngularVelocity", Gf.Vec3f(0))):
        refuse(prim, "a surface that turns is not supported", "author surfaceVelocity alone, or turn the body itself")
    given = Gf.Vec3d(value(prim, f"{_BELT}Velocity", Gf.Vec3f(0)))
    if any(given) and owner.motion != "kinematic":
        reason = f"a surface velocity of a {owner.motion} body is not supported"
        refuse(prim, reason, "author physics:kinematicEnabled = true")
    if value(prim, f"{_BELT}VelocityLocalSpace", True):
        x, y, z = vector(given) * world.meters
    else:
        x, y, z = rotate(conjugate(pose.orientation), world.direction(given) * world.meters)
    return float(x), float(y), float(z)
