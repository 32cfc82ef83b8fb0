"""Bodies as plain numbers: what is said to an engine, in an order and words that suit all of them.

The native scripts contain these definitions as they stand here, and the `repr` of a `Rigid` is the Python text of it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from wmspec.core.memoize import cached_on
from wmspec.sim.scene.joints.articulations import Gear, Tie, Tree, jointed, ties, trees
from wmspec.sim.scene.joints.com_frame import com_frame, placed
from wmspec.sim.scene.joints.coordinates import gears
from wmspec.sim.scene.model import Body, Geom, Scene
from wmspec.sim.scene.model.numbers import floats, numbers
from wmspec.sim.scene.model.transform import identity
from wmspec.sim.scene.physics.contact import apart, colliders
from wmspec.sim.scene.physics.episode import Episode, Vector


@dataclass(frozen=True)
class Piece:
    """A shape that collides, m.

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

    `damping`: linear and angular rate, 1/s. `velocity`: linear and angular at the start, in world axes, of a body with
    joints that begins to move; others are kicked by the episode.
    """

    name: str
    motion: str
    start: Vector
    mass: float
    moments: Vector
    damping: Vector
    pieces: tuple[Piece, ...]
    velocity: Vector = ()


@dataclass(frozen=True)
class Assembly:
    """All bodies in order, and how they hang together.

    Trees of those with joints, pairs of numbers that pass through each other, loops, and joints that mimic others.
    """

    bodies: tuple[Rigid, ...]
    trees: tuple[Tree, ...]
    apart: tuple[tuple[int, int], ...]
    gravity: tuple[float, ...]
    step: float
    ties: tuple[Tie, ...] = ()
    gears: tuple[Gear, ...] = ()


def assembly(scene: Scene, episode: Episode) -> Assembly:
    """What a world is built of. Raises WmsError for joints that no engine can have."""
    passing = tuple(sorted(apart(scene)))
    return Assembly(rigids(scene), trees(scene), passing, episode.gravity, episode.step, ties(scene), gears(scene))


def rigids(scene: Scene) -> tuple[Rigid, ...]:
    """The scene's bodies, in order."""
    tied = jointed(scene)
    return tuple(
        _rigid(com_frame(body), tied=True) if body.name in tied else cached_on(body, _loose) for body in scene.bodies
    )


def _loose(body: Body) -> Rigid:
    return _rigid(com_frame(body), tied=False)


def _rigid(body: Body, *, tied: bool) -> Rigid:
    speeds = np.concatenate([body.linear_velocity, body.angular_velocity])
    return Rigid(
        name=body.name,
        motion=body.motion,
        start=numbers(body.pose),
        mass=body.mass,
        moments=floats(body.inertia.moments if body.inertia else np.zeros(3)),
        damping=(float(body.linear_damping), float(body.angular_damping)),
        pieces=tuple(map(_piece, colliders(body))),
        velocity=floats(speeds) if tied and speeds.any() else (),
    )


def _piece(geom: Geom) -> Piece:
    f, pose = geom.friction, geom.pose
    if geom.shape.primitive is not None:
        kind, size = geom.shape.primitive
    else:
        kind, size, pose = "hull", floats(placed(pose, geom.shape.corners())), identity()
    return Piece(kind, size, numbers(pose), (float(f.static), float(f.dynamic), float(f.restitution)))
