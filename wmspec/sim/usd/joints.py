"""Joints of UsdPhysics between any two prims: hinges, sliders, ball joints, fixed joints, and chains of them.

A joint with several free axes becomes a chain of joints with one axis each and light link bodies: first it slides along
x, y and z, then it rotates about them.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from pxr import Gf, Usd

from wmspec.core.diagnostics import Report
from wmspec.sim.scene.model import Body, Inertia, Joint, JointKind, Pose
from wmspec.sim.scene.model.transform import compose, from_rotation_vector, identity, inverse, multiply, rotation
from wmspec.sim.usd.drives import drive, has_drive
from wmspec.sim.usd.frames import StageFrame, quaternion, split_transform, vector
from wmspec.sim.usd.mimics import mimics
from wmspec.sim.usd.prims import Names, applied_schemas, existing_targets, refuse, value
from wmspec.sim.usd.substitutions import STRICT, Substitutions

_HALF = math.sqrt(0.5)
_TURNS = {"X": (1.0, 0.0, 0.0, 0.0), "Y": (_HALF, 0.0, 0.0, _HALF), "Z": (_HALF, 0.0, -_HALF, 0.0)}
"""Axis -> rotation from x to it."""

_End = tuple[Body | None, Pose]
_HALF_TURN_Z = Pose(np.zeros(3), np.array([0.0, 0.0, 0.0, 1.0]))
ARMATURES = ("newton:armature", "mjc:armature", "physxJoint:armature")
"""Attributes of an armature; UsdPhysics has none."""
_AXIS_NAMES = ("transX", "transY", "transZ", "rotX", "rotY", "rotZ")
_SAME = 1e-9


@dataclass(frozen=True)
class _FreeAxis:
    """A free axis: joint kind, axis, limits (rad, m) and the name of its drive."""

    kind: JointKind
    axis: str
    limits: tuple[float, float] | None
    drive: str


@dataclass(frozen=True)
class JointSet:
    """Joints by path, those of a chain with the axis after a dot; and the link bodies between them."""

    joints: dict[str, Joint]
    between: tuple[Body, ...] = ()


def joints(
    prims: list[Usd.Prim],
    bodies: Mapping[str, Body],
    world: StageFrame,
    problems: Report,
    notes: Substitutions = STRICT,
) -> JointSet:
    """Return the joints, without those that join no dynamic body. `bodies` by path."""
    names, by_path = Names(), dict[str, Joint]()
    between: list[Body] = []
    for body in bodies.values():
        names.give(body.name)
    for prim in prims:
        with problems.collect_errors():
            if value(prim, "physics:jointEnabled", True):
                made = _joint(prim, names, bodies, world, notes)
                by_path |= made.joints
                between += made.between
    return JointSet(mimics(prims, by_path, world, problems, notes), tuple(between))


def _joint(
    prim: Usd.Prim, names: Names, bodies: Mapping[str, Body], world: StageFrame, notes: Substitutions
) -> JointSet:
    for breaks in ("Force", "Torque"):
        if value(prim, f"physics:break{breaks}", math.inf) < 1e30:
            refuse(prim, "joints that break are not supported", f"author physics:break{breaks} = inf")
    ways, path = _free_axes(prim, world, notes), str(prim.GetPath())
    axis = ways[0].axis if len(ways) == 1 else "X"  # each joint of a chain uses its own axis
    ends = (first, above), (second, below) = [_end(prim, i, axis, bodies, world) for i in (0, 1)]
    moving = [body for body in (first, second) if body is not None and body.motion == "dynamic"]
    if not moving or not ways:
        return JointSet({})
    if first is second:
        refuse(prim, f"it joins {moving[0].path} to itself", "target two bodies, or one and the world")
    if len(ways) == 1:
        name = names.give(prim.GetName(), path)
        return JointSet({path: _single(prim, name, ways[0], ends[0], ends[1], ways, world, notes)})
    here = compose(first.pose, above) if first else above
    there = compose(second.pose, below) if second else below
    joined, between, last = {}, [], ends[0]
    for way, frame in zip(ways, _frames(here, there, ways), strict=True):
        name = names.give(f"{prim.GetName()}_{way.drive or way.kind}", f"{path}/{way.drive or way.kind}")
        if way is ways[-1]:
            after: _End = ends[1]
        else:
            between.append(_link_body(f"{name}_link", path, frame, moving))
            after = (between[-1], identity())
        turn = Pose(np.zeros(3), np.array(_TURNS[way.axis]))
        outer, inner = ((body, compose(frame, turn)) for body, frame in (last, after))
        joined[f"{path}.{way.drive or way.kind}"] = _single(prim, name, way, outer, inner, ways, world, notes)
        last = after
    mass = max(body.inertia.mass for body in between if body.inertia)
    notes.record(
        prim,
        f"a joint that leaves {', '.join(way.drive or way.kind for way in ways)} free is not supported",
        f"it is a chain of {len(ways)} joints in this order, with link bodies of {mass:.2g} kg between",
        "lock all axes but one",
    )
    return JointSet(joined, tuple(between))


_LINK_MASS_RATIO = 1e-5
"""Mass of a link body relative to the lightest body that the chain joins."""


def _link_body(name: str, path: str, pose: Pose, moving: Sequence[Body]) -> Body:
    """Return a link body of a chain, which does not collide."""
    inertias = [body.inertia for body in moving if body.inertia]
    mass = _LINK_MASS_RATIO * min(one.mass for one in inertias)
    moments = np.full(3, _LINK_MASS_RATIO * min(one.moments.min() for one in inertias))
    own = identity()
    at_rest = np.zeros(3)
    inertia = Inertia(mass, own.position, own.orientation, moments)
    return Body(name, path, "dynamic", pose, (), inertia, at_rest, at_rest)


def _frames(here: Pose, there: Pose, ways: Sequence[_FreeAxis]) -> Iterator[Pose]:
    """Yield the world frames of the joint after each axis, from `here` to `there`.

    The rotations about x, y and z are those of a rotation matrix Rx Ry Rz.
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
            turn = between.orientation if way.kind == "ball" else from_rotation_vector(axis * angles[number])
            step = Pose(np.zeros(3), turn)
        here = compose(here, step)
        yield here


def _single(
    prim: Usd.Prim,
    name: str,
    way: _FreeAxis,
    above: _End,
    below: _End,
    ways: Sequence[_FreeAxis],
    world: StageFrame,
    notes: Substitutions,
) -> Joint:
    """Return one joint between two bodies (or the world), given its frames in them."""
    (first, outer), (second, inner) = above, below
    if second is None:  # reverse the axis with the ends, so that the coordinate keeps its sign
        (first, outer), (second, inner) = (None, compose(inner, _HALF_TURN_Z)), (first, compose(outer, _HALF_TURN_Z))
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
        armature=_armature(prim, way.kind, world, notes),
    )


def _armature(prim: Usd.Prim, kind: JointKind, world: StageFrame, notes: Substitutions) -> float:
    """Return the armature (kg m² of a hinge, kg of a slider), the first that is authored."""
    name = next((name for name in ARMATURES if value(prim, name, 0.0)), None)
    if name is None or kind == "fixed":
        return 0.0
    given = float(value(prim, name, 0.0))
    if not 0 < given < math.inf:
        refuse(prim, f"{name} = {given:g}", "author 0 or more")
    if kind == "ball":
        notes.record(prim, f"{name} of a ball joint is not supported", "left out", "use three hinges")
        return 0.0
    return given * world.kilograms * (world.meters**2 if kind == "hinge" else 1.0)


def _end(prim: Usd.Prim, number: int, axis: str, bodies: Mapping[str, Body], world: StageFrame) -> _End:
    """Return the body at an end, or None for the world, and the joint frame in it with the axis along x."""
    paths = existing_targets(prim, f"physics:body{number}")
    if len(paths) > 1:
        refuse(prim, f"physics:body{number} has {len(paths)} targets", "target one prim, or none for the world")
    at = prim.GetStage().GetPrimAtPath(paths[0]) if paths else None
    place = world.matrix(at) if at else world.units
    spot = place.Transform(Gf.Vec3d(value(prim, f"physics:localPos{number}", Gf.Vec3f(0))))
    turn = value(prim, f"physics:localRot{number}", Gf.Quatf(1))
    if not turn.GetLength() > 0:
        refuse(prim, f"physics:localRot{number} is not a rotation", "author a unit quaternion")
    orientation = quaternion(split_transform(place, prim).rigid.ExtractRotationQuat() * Gf.Quatd(turn).GetNormalized())
    here = Pose(vector(spot), multiply(orientation, np.array(_TURNS[axis])))
    body = next((bodies[str(p)] for p in at.GetPath().GetAncestorsRange() if str(p) in bodies), None) if at else None
    return body, compose(inverse(body.pose), here) if body else here


def _free_axes(prim: Usd.Prim, world: StageFrame, notes: Substitutions) -> tuple[_FreeAxis, ...]:
    if str(prim.GetTypeName()) not in _KINDS:
        return _generic_axes(prim, world, notes)
    return (_simple_axis(prim, world),)


_KINDS = tuple(f"Physics{kind}Joint" for kind in ("Fixed", "Revolute", "Prismatic", "Spherical", "Distance"))


def _simple_axis(prim: Usd.Prim, world: StageFrame) -> _FreeAxis:
    axis = str(value(prim, "physics:axis", "X"))
    if axis not in _TURNS:
        refuse(prim, f"physics:axis = {axis[:40]!r}", "expected X, Y or Z")
    match str(prim.GetTypeName()):
        case "PhysicsFixedJoint":
            return _FreeAxis("fixed", "X", None, "")
        case "PhysicsRevoluteJoint":
            low, high = (math.radians(value(prim, f"physics:{end}Limit", inf)) for end, inf in _ENDS)
            return _FreeAxis("hinge", axis, _limits(prim, low, high), "angular")
        case "PhysicsPrismaticJoint":
            low, high = (world.meters * value(prim, f"physics:{end}Limit", inf) for end, inf in _ENDS)
            return _FreeAxis("slider", axis, _limits(prim, low, high), "linear")
        case "PhysicsSphericalJoint":
            return _FreeAxis("ball", axis, _cone(prim), "")
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


def _generic_axes(prim: Usd.Prim, world: StageFrame, notes: Substitutions) -> tuple[_FreeAxis, ...]:
    """Return the free axes of a generic joint: no PhysicsLimitAPI means free, low > high means locked."""
    left = dict(_unlocked(prim))
    turns, slides = [way for way in left if way[:3] == "rot"], [way for way in left if way[:3] == "tra"]
    if not left:
        return (_FreeAxis("fixed", "X", None, ""),)
    ball = len(turns) == 3 and all(left[turn] is None for turn in turns)
    if len(left) > 1 and notes.strict and not (ball and not slides):
        refuse(prim, f"a joint that leaves {', '.join(left)} free is not supported", "lock all axes but one")
    pushed = any(has_drive(prim, name) for name in (*_AXIS_NAMES, "angular", "linear"))
    if len(left) == len(_AXIS_NAMES) and not pushed and not any(left.values()):
        return ()
    if ball and not (slides and pushed):
        left = {way: left[way] for way in slides}
        return (*(_axis(prim, way, left[way], world) for way in left), _FreeAxis("ball", "X", None, ""))
    return tuple(_axis(prim, way, limits, world) for way, limits in left.items())


def _axis(prim: Usd.Prim, way: str, limits: tuple[float, float] | None, world: StageFrame) -> _FreeAxis:
    turns = way.startswith("rot")
    scale = math.radians(1) if turns else world.meters
    low, high = (scale * limit for limit in limits or (-math.inf, math.inf))
    return _FreeAxis("hinge" if turns else "slider", way[-1], _limits(prim, low, high), way)


def _unlocked(prim: Usd.Prim) -> Iterator[tuple[str, tuple[float, float] | None]]:
    apis = applied_schemas(prim)
    for way in _AXIS_NAMES:
        if f"PhysicsLimitAPI:{way}" not in apis:
            yield way, None
            continue
        low = float(value(prim, f"limit:{way}:physics:low", -math.inf))
        high = float(value(prim, f"limit:{way}:physics:high", math.inf))
        if low <= high:
            yield way, (low, high)
