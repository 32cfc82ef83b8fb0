"""The joints of UsdPhysics between any two prims: hinges, sliders, ball joints and fixed ones, and chains of such.

A joint that leaves several axes free is a chain of joints of one each, with light bodies between them: first it slides
along its x, y and z, then it turns about them.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from pxr import Gf, Usd

from wmspec.core.diagnostics import Report
from wmspec.sim.scene.model import Body, Inertia, Joint, JointKind, Pose
from wmspec.sim.scene.model.transform import compose, identity, inverse, multiply, rotation, turning
from wmspec.sim.usd.drives import drive, drives
from wmspec.sim.usd.frames import World, quaternion, split, vector
from wmspec.sim.usd.mimics import mimics
from wmspec.sim.usd.prims import Names, applied, present, refuse, value
from wmspec.sim.usd.substitutions import STRICT, Notes

_HALF = math.sqrt(0.5)
_TURNS = {"X": (1.0, 0.0, 0.0, 0.0), "Y": (_HALF, 0.0, 0.0, _HALF), "Z": (_HALF, 0.0, -_HALF, 0.0)}
"""Axis -> the turn that brings x there."""

_End = tuple[Body | None, Pose]
_OVER = Pose(np.zeros(3), np.array([0.0, 0.0, 0.0, 1.0]))
_WAYS = ("transX", "transY", "transZ", "rotX", "rotY", "rotZ")
_SAME = 1e-9


@dataclass(frozen=True)
class _Way:
    """What a joint leaves free: its kind, its axis, its limits (rad, m) and the name of the drive that it may have."""

    kind: JointKind
    axis: str
    limits: tuple[float, float] | None
    drive: str


@dataclass(frozen=True)
class Held:
    """The joints by their paths, those of a chain with the axis after a dot; and the bodies between them."""

    joints: dict[str, Joint]
    between: tuple[Body, ...] = ()


def joints(
    prims: list[Usd.Prim], bodies: Mapping[str, Body], world: World, problems: Report, notes: Notes = STRICT
) -> Held:
    """The joints; those that hold nothing that can move are left out. `bodies` by their paths."""
    names, by_path = Names(), dict[str, Joint]()
    between: list[Body] = []
    for body in bodies.values():
        names.give(body.name)
    for prim in prims:
        with problems.gathered():
            if value(prim, "physics:jointEnabled", True):
                made = _joint(prim, names, bodies, world, notes)
                by_path |= made.joints
                between += made.between
    return Held(mimics(prims, by_path, world, problems, notes), tuple(between))


def _joint(prim: Usd.Prim, names: Names, bodies: Mapping[str, Body], world: World, notes: Notes) -> Held:
    for breaks in ("Force", "Torque"):
        if value(prim, f"physics:break{breaks}", math.inf) < 1e30:
            refuse(prim, "joints that break are not supported", f"author physics:break{breaks} = inf")
    ways, path = _ways(prim, world, notes), str(prim.GetPath())
    axis = ways[0].axis if len(ways) == 1 else "X"  # of a chain, each joint turns to its own
    ends = (first, above), (second, below) = [_end(prim, i, axis, bodies, world) for i in (0, 1)]
    moving = [body for body in (first, second) if body is not None and body.motion == "dynamic"]
    if not moving or not ways:
        return Held({})
    if first is second:
        refuse(prim, f"it joins {moving[0].path} to itself", "target two bodies, or one and the world")
    if len(ways) == 1:
        name = names.give(prim.GetName(), path)
        return Held({path: _single(prim, name, ways[0], ends[0], ends[1], ways, world, notes)})
    here = compose(first.pose, above) if first else above
    there = compose(second.pose, below) if second else below
    joined, between, last = {}, [], ends[0]
    for way, frame in zip(ways, _frames(here, there, ways), strict=True):
        name = names.give(f"{prim.GetName()}_{way.drive or way.kind}", f"{path}/{way.drive or way.kind}")
        if way is ways[-1]:
            after: _End = ends[1]
        else:
            between.append(_light(f"{name}_link", path, frame, moving))
            after = (between[-1], identity())
        turn = Pose(np.zeros(3), np.array(_TURNS[way.axis]))
        outer, inner = ((body, compose(frame, turn)) for body, frame in (last, after))
        joined[f"{path}.{way.drive or way.kind}"] = _single(prim, name, way, outer, inner, ways, world, notes)
        last = after
    mass = max(body.inertia.mass for body in between if body.inertia)
    notes.instead(
        prim,
        f"a joint that leaves {', '.join(way.drive or way.kind for way in ways)} free is not supported",
        f"it is a chain of {len(ways)} joints in this order, with bodies of {mass:.2g} kg between",
        "lock all axes but one",
    )
    return Held(joined, tuple(between))


_LIGHT = 1e-5
"""The mass of a body between the joints of a chain, as part of that of the lightest body that the chain holds."""


def _light(name: str, path: str, pose: Pose, moving: Sequence[Body]) -> Body:
    """A body between two joints of a chain, which nothing touches."""
    inertias = [body.inertia for body in moving if body.inertia]
    mass = _LIGHT * min(one.mass for one in inertias)
    moments = np.full(3, _LIGHT * min(one.moments.min() for one in inertias))
    own = identity()
    at_rest = np.zeros(3)
    inertia = Inertia(mass, own.position, own.orientation, moments)
    return Body(name, path, "dynamic", pose, (), inertia, at_rest, at_rest)


def _frames(here: Pose, there: Pose, ways: Sequence[_Way]) -> Iterator[Pose]:
    """Where the joint's frame is after each of the ways, in the world, if it is `here` before and `there` after them.

    The turns about x, y and z are those of a rotation matrix Rx Ry Rz.
    """
    between = compose(inverse(here), there)
    m = rotation(between.orientation)
    angles = (math.atan2(-m[1, 2], m[2, 2]), math.asin(min(1.0, max(-1.0, m[0, 2]))), math.atan2(-m[0, 1], m[0, 0]))
    for way in ways:
        number = "XYZ".index(way.axis)
        axis = np.eye(3)[number]
        if way.kind == "slider":
            step = Pose(axis * between.position[number], identity().orientation)
        else:
            turn = between.orientation if way.kind == "ball" else turning(axis * angles[number])
            step = Pose(np.zeros(3), turn)
        here = compose(here, step)
        yield here


def _single(
    prim: Usd.Prim,
    name: str,
    way: _Way,
    above: _End,
    below: _End,
    ways: Sequence[_Way],
    world: World,
    notes: Notes,
) -> Joint:
    """One joint, between a body (or the world) and another, by its frames in them."""
    (first, outer), (second, inner) = above, below
    if second is None:  # the axis is turned round with the two ends, so that the coordinate keeps its sign
        (first, outer), (second, inner) = (None, compose(inner, _OVER)), (first, compose(outer, _OVER))
    assert second is not None
    return Joint(
        name,
        str(prim.GetPath()),
        way.kind,
        first.name if first else None,
        second.name,
        outer,
        inner,
        way.limits,
        None if way.kind == "fixed" else drive(prim, way.drive, world, [other.drive for other in ways], notes),
        bool(value(prim, "physics:collisionEnabled", False)),
    )


def _end(prim: Usd.Prim, number: int, axis: str, bodies: Mapping[str, Body], world: World) -> _End:
    """The body at an end, or None for the world, and the joint's frame in it, its axis along x."""
    paths = present(prim, f"physics:body{number}")
    if len(paths) > 1:
        refuse(prim, f"physics:body{number} has {len(paths)} targets", "target one prim, or none for the world")
    at = prim.GetStage().GetPrimAtPath(paths[0]) if paths else None
    place = world.matrix(at) if at else world.units
    spot = place.Transform(Gf.Vec3d(value(prim, f"physics:localPos{number}", Gf.Vec3f(0))))
    turn = value(prim, f"physics:localRot{number}", Gf.Quatf(1))
    if not turn.GetLength() > 0:
        refuse(prim, f"physics:localRot{number} is no turn", "author a unit quaternion")
    orientation = quaternion(split(place, prim).rigid.ExtractRotationQuat() * Gf.Quatd(turn).GetNormalized())
    here = Pose(vector(spot), multiply(orientation, np.array(_TURNS[axis])))
    body = next((bodies[str(p)] for p in at.GetPath().GetAncestorsRange() if str(p) in bodies), None) if at else None
    return body, compose(inverse(body.pose), here) if body else here


def _ways(prim: Usd.Prim, world: World, notes: Notes) -> tuple[_Way, ...]:
    if str(prim.GetTypeName()) not in _KINDS:
        return _reduced(prim, world, notes)
    return (_way(prim, world),)


_KINDS = tuple(f"Physics{kind}Joint" for kind in ("Fixed", "Revolute", "Prismatic", "Spherical", "Distance"))


def _way(prim: Usd.Prim, world: World) -> _Way:
    axis = str(value(prim, "physics:axis", "X"))
    if axis not in _TURNS:
        refuse(prim, f"physics:axis = {axis[:40]!r}", "expected X, Y or Z")
    match str(prim.GetTypeName()):
        case "PhysicsFixedJoint":
            return _Way("fixed", "X", None, "")
        case "PhysicsRevoluteJoint":
            low, high = (math.radians(value(prim, f"physics:{end}Limit", inf)) for end, inf in _ENDS)
            return _Way("hinge", axis, _limits(prim, low, high), "angular")
        case "PhysicsPrismaticJoint":
            low, high = (world.meters * value(prim, f"physics:{end}Limit", inf) for end, inf in _ENDS)
            return _Way("slider", axis, _limits(prim, low, high), "linear")
        case "PhysicsSphericalJoint":
            return _Way("ball", axis, _cone(prim), "")
        case _:
            refuse(prim, "distance joints are not supported", "use a fixed or spherical joint, or deactivate it")


_ENDS = (("lower", -math.inf), ("upper", math.inf))


def _limits(prim: Usd.Prim, low: float, high: float) -> tuple[float, float] | None:
    if low > high or low == math.inf or high == -math.inf:
        refuse(prim, f"its limits are {low:g} and {high:g}", "author the lower limit below the upper one")
    if high - low < _SAME:
        refuse(prim, "its limits are equal", "use a PhysicsFixedJoint")
    return None if low < -1e30 and high > 1e30 else (max(low, -math.inf), high)


def _cone(prim: Usd.Prim) -> tuple[float, float] | None:
    angles = [float(value(prim, f"physics:coneAngle{i}Limit", -1.0)) for i in (0, 1)]
    if max(angles) < 0:
        return None
    first, second = (math.radians(angle) if angle >= 0 else math.pi for angle in angles)
    return first, second


def _reduced(prim: Usd.Prim, world: World, notes: Notes) -> tuple[_Way, ...]:
    """A generic joint as some of ours: an axis without PhysicsLimitAPI is free, one with low > high is locked."""
    left = dict(_free(prim))
    turns, slides = [way for way in left if way[:3] == "rot"], [way for way in left if way[:3] == "tra"]
    if not left:
        return (_Way("fixed", "X", None, ""),)
    ball = len(turns) == 3 and all(left[turn] is None for turn in turns)
    if len(left) > 1 and notes.strict and not (ball and not slides):
        refuse(prim, f"a joint that leaves {', '.join(left)} free is not supported", "lock all axes but one")
    pushed = any(drives(prim, name) for name in (*_WAYS, "angular", "linear"))
    if len(left) == len(_WAYS) and not pushed and not any(left.values()):
        return ()
    if ball and not (slides and pushed):
        left = {way: left[way] for way in slides}
        return (*(_axis(prim, way, left[way], world) for way in left), _Way("ball", "X", None, ""))
    return tuple(_axis(prim, way, limits, world) for way, limits in left.items())


def _axis(prim: Usd.Prim, way: str, limits: tuple[float, float] | None, world: World) -> _Way:
    turns = way.startswith("rot")
    scale = math.radians(1) if turns else world.meters
    low, high = (scale * limit for limit in limits or (-math.inf, math.inf))
    return _Way("hinge" if turns else "slider", way[-1], _limits(prim, low, high), way)


def _free(prim: Usd.Prim) -> Iterator[tuple[str, tuple[float, float] | None]]:
    apis = applied(prim)
    for way in _WAYS:
        if f"PhysicsLimitAPI:{way}" not in apis:
            yield way, None
            continue
        low = float(value(prim, f"limit:{way}:physics:low", -math.inf))
        high = float(value(prim, f"limit:{way}:physics:high", math.inf))
        if low <= high:
            yield way, (low, high)
