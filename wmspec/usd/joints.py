"""The joints of UsdPhysics: of any kind that is a hinge, a slider, a ball joint or fixed, between any two prims."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np
from pxr import Gf, Usd

from wmspec.diagnostics import Report
from wmspec.scene.model import Body, Joint, JointKind, Pose
from wmspec.scene.transform import compose, inverse, multiply
from wmspec.usd.drives import drive
from wmspec.usd.frames import World, quaternion, split, vector
from wmspec.usd.prims import Names, applied, present, refuse, value

_HALF = math.sqrt(0.5)
_TURNS = {"X": (1.0, 0.0, 0.0, 0.0), "Y": (_HALF, 0.0, 0.0, _HALF), "Z": (_HALF, 0.0, -_HALF, 0.0)}
"""Axis -> the turn that brings x there."""

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


def joints(prims: list[Usd.Prim], bodies: Mapping[str, Body], world: World, problems: Report) -> dict[str, Joint]:
    """The joints by their paths; those that hold nothing that can move are left out. `bodies` by their paths."""
    names, by_path = Names(), {}
    for body in bodies.values():
        names.give(body.name)
    for prim in prims:
        with problems.gathered():
            if value(prim, "physics:jointEnabled", True):
                joint = _joint(prim, names.give(prim.GetName(), str(prim.GetPath())), bodies, world)
                if joint is not None:
                    by_path[joint.path] = joint
    return by_path


def _joint(prim: Usd.Prim, name: str, bodies: Mapping[str, Body], world: World) -> Joint | None:
    for breaks in ("Force", "Torque"):
        if value(prim, f"physics:break{breaks}", math.inf) < 1e30:
            refuse(prim, "joints that break are not supported", f"author physics:break{breaks} = inf")
    way = _way(prim, world)
    (first, above), (second, below) = (_end(prim, i, way.axis, bodies, world) for i in (0, 1))
    moving = [body for body in (first, second) if body is not None and body.motion == "dynamic"]
    if not moving:
        return None
    if first is second:
        refuse(prim, f"it joins {moving[0].path} to itself", "target two bodies, or one and the world")
    if second is None:  # the axis is turned round with the two ends, so that the coordinate keeps its sign
        (first, above), (second, below) = (None, compose(below, _OVER)), (first, compose(above, _OVER))
    assert second is not None
    return Joint(
        name,
        str(prim.GetPath()),
        way.kind,
        first.name if first else None,
        second.name,
        above,
        below,
        way.limits,
        None if way.kind == "fixed" else drive(prim, way.drive, world),
        bool(value(prim, "physics:collisionEnabled", False)),
    )


def _end(prim: Usd.Prim, number: int, axis: str, bodies: Mapping[str, Body], world: World) -> tuple[Body | None, Pose]:
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
        case "PhysicsDistanceJoint":
            refuse(prim, "distance joints are not supported", "use a fixed or spherical joint, or deactivate it")
        case _:
            return _reduced(prim, world)


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


def _reduced(prim: Usd.Prim, world: World) -> _Way:
    """A generic joint as one of ours: an axis without PhysicsLimitAPI is free, one with low > high is locked."""
    left = dict(_free(prim))
    turns, slides = [way for way in left if way[:3] == "rot"], [way for way in left if way[:3] == "tra"]
    if not left:
        return _Way("fixed", "X", None, "")
    if len(turns) == 3 and not slides and all(limits is None for limits in left.values()):
        return _Way("ball", "X", None, "")
    if len(left) > 1:
        refuse(prim, f"a joint that leaves {', '.join(left)} free is not supported", "lock all axes but one")
    ((way, limits),) = left.items()
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
