"""Rigid bodies as plain numbers, in the form that all engines receive.

Native scripts contain a copy of these definitions. The `repr` of a `Rigid` is valid Python.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from wmspec.core.memoize import cached_on
from wmspec.sim.scene.joints.articulations import (
    LoopClosure,
    MimicConstraint,
    Tree,
    jointed_bodies,
    loop_closures,
    trees,
)
from wmspec.sim.scene.joints.com_frame import com_frame, transform_points
from wmspec.sim.scene.joints.coordinates import mimic_constraints
from wmspec.sim.scene.model import Body, Geom, Scene
from wmspec.sim.scene.model.numbers import floats, pose_numbers
from wmspec.sim.scene.model.transform import identity
from wmspec.sim.scene.physics.contact import colliders, non_colliding_pairs
from wmspec.sim.scene.physics.episode import Episode, Vector


@dataclass(frozen=True)
class CollisionShape:
    """A colliding shape, m.

    `kind` is box (`size`: half-extents), sphere (radius), cylinder or capsule (radius, height of the straight part,
    along z) or hull (`size`: corners, flat). `pose`: position, quaternion (w, x, y, z).
    `material`: static friction, dynamic friction, restitution.
    """

    kind: str
    size: Vector
    pose: Vector
    material: Vector


@dataclass(frozen=True)
class Rigid:
    """A body in its centre-of-mass frame, SI units.

    `damping`: linear and angular rate, 1/s. `velocity`: initial linear and angular velocity of a jointed body, in
    world axes; kicks of the episode set the others.
    """

    name: str
    motion: str
    start: Vector
    mass: float
    moments: Vector
    damping: Vector
    pieces: tuple[CollisionShape, ...]
    velocity: Vector = ()


@dataclass(frozen=True)
class Assembly:
    """All bodies in order, trees of jointed bodies, pairs that do not collide, loop joints, and mimic joints."""

    bodies: tuple[Rigid, ...]
    trees: tuple[Tree, ...]
    non_colliding_pairs: tuple[tuple[int, int], ...]
    gravity: tuple[float, ...]
    step: float
    loop_closures: tuple[LoopClosure, ...] = ()
    mimic_constraints: tuple[MimicConstraint, ...] = ()


def assembly(scene: Scene, episode: Episode) -> Assembly:
    """Return the bodies and joints of a scene. Raises WmsError for joints that no engine supports."""
    passing = tuple(sorted(non_colliding_pairs(scene)))
    return Assembly(
        rigids(scene),
        trees(scene),
        passing,
        episode.gravity,
        episode.step,
        loop_closures(scene),
        mimic_constraints(scene),
    )


def rigids(scene: Scene) -> tuple[Rigid, ...]:
    """Return the bodies of a scene in order."""
    tied = jointed_bodies(scene)
    return tuple(
        _rigid(com_frame(body), tied=True) if body.name in tied else cached_on(body, _unjointed)
        for body in scene.bodies
    )


def _unjointed(body: Body) -> Rigid:
    return _rigid(com_frame(body), tied=False)


def _rigid(body: Body, *, tied: bool) -> Rigid:
    speeds = np.concatenate([body.linear_velocity, body.angular_velocity])
    return Rigid(
        name=body.name,
        motion=body.motion,
        start=pose_numbers(body.pose),
        mass=body.mass,
        moments=floats(body.inertia.moments if body.inertia else np.zeros(3)),
        damping=(float(body.linear_damping), float(body.angular_damping)),
        pieces=tuple(map(_piece, colliders(body))),
        velocity=floats(speeds) if tied and speeds.any() else (),
    )


def _piece(geom: Geom) -> CollisionShape:
    f, pose = geom.friction, geom.pose
    if geom.shape.primitive is not None:
        kind, size = geom.shape.primitive
    else:
        kind, size, pose = "hull", floats(transform_points(pose, geom.shape.corners())), identity()
    return CollisionShape(kind, size, pose_numbers(pose), (float(f.static), float(f.dynamic), float(f.restitution)))
