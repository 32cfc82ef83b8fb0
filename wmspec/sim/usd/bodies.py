"""The bodies of a scene: every rigid body of the stage, and every group of geometries that never moves."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from pxr import Gf

from wmspec.core.diagnostics import Report, StageError
from wmspec.sim.scene.model import Array, Body, Geom, Inertia, Pose
from wmspec.sim.scene.model.transform import conjugate, rotate
from wmspec.sim.usd.colliders import DOWN, collider
from wmspec.sim.usd.frames import World, split, vector
from wmspec.sim.usd.geoms import Materials, geoms
from wmspec.sim.usd.masses import body_inertia
from wmspec.sim.usd.prims import Names, refuse, value
from wmspec.sim.usd.shapes import Placed, placed
from wmspec.sim.usd.stage_index import Owner
from wmspec.sim.usd.substitutions import STRICT, Notes


def bodies(owners: Sequence[Owner], world: World, problems: Report, notes: Notes = STRICT) -> tuple[Body, ...]:
    """The bodies, in the stage's order; what is wrong with them goes to `problems`."""
    materials = Materials((piece for owner in owners for piece in owner.pieces), notes=notes)
    names, read = Names(), []
    for owner in owners:
        name = names.give(owner.prim.GetName(), str(owner.prim.GetPath()))
        with problems.gathered():
            read.append(_body(owner, name, world, materials, notes))
    return tuple(read)


def _body(owner: Owner, name: str, world: World, materials: Materials, notes: Notes) -> Body:
    prim, path = owner.prim, str(owner.prim.GetPath())
    place = split(world.matrix(prim), prim)
    inverse = place.rigid.GetInverse()
    down = rotate(conjugate(place.pose.orientation), DOWN)
    problems, names = Report(StageError), Names()
    pieces: list[Geom] = []
    colliders: list[tuple[Placed, float]] = []
    for piece in owner.pieces:
        with problems.gathered():
            here = placed(piece.prim, split(world.matrix(piece.prim) * inverse, piece.prim), notes)
            below = str(piece.prim.GetPath()).removeprefix(path)
            touched = collider(here, owner.motion, down, notes) if piece.collides else ()
            pieces += geoms(piece, here, touched, names.give(below or prim.GetName()), names, materials)
            if piece.collides:
                colliders.append((here, materials.density(piece.prim)))
    problems.stop_if_failed()
    seen = [(geom.shape, geom.pose) for geom in pieces]
    inertia = body_inertia(prim, place, colliders, world, seen, notes) if owner.motion == "dynamic" else None
    return body(owner, name, place.pose, tuple(pieces), inertia, world)


def body(owner: Owner, name: str, pose: Pose, geoms: tuple[Geom, ...], inertia: Inertia | None, world: World) -> Body:
    """A body of these, with its velocities and dampings. Raises StageError if it is kinematic and has velocities."""
    damping = (float(value(owner.prim, f"physxRigidBody:{kind}Damping", 0.0)) for kind in ("linear", "angular"))
    path = str(owner.prim.GetPath())
    return Body(name, path, owner.motion, pose, geoms, inertia, *_velocities(owner, world), *damping)


def _velocities(owner: Owner, world: World) -> tuple[Array, Array]:
    """Linear (m/s) and angular (rad/s), from the space in which the prim's own transform is given, to the world."""
    linear = Gf.Vec3d(value(owner.prim, "physics:velocity", Gf.Vec3f(0)))
    angular = Gf.Vec3d(value(owner.prim, "physics:angularVelocity", Gf.Vec3f(0)))
    if owner.motion == "static" or not (any(linear) or any(angular)):
        return np.zeros(3), np.zeros(3)
    if owner.motion == "kinematic":
        refuse(owner.prim, "a kinematic body with a velocity is not supported", "move it by a WmsAction that glides")
    parent = world.parent(owner.prim)
    turn = split(parent, owner.prim).rigid
    return vector(parent.TransformDir(linear)), np.radians(vector(turn.TransformDir(angular)))
