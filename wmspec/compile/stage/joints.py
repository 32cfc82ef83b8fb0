"""Joints as UsdPhysics prims; UsdPhysics measures angles in degrees."""

from __future__ import annotations

import math
from collections.abc import Mapping

from wmspec.compile.layout import assets, placement
from wmspec.compile.layout.evaluator import Evaluator
from wmspec.compile.stage.document import Document, Prim
from wmspec.compile.stage.objects import object_path
from wmspec.core.diagnostics import ImpossibleValue
from wmspec.core.space import IDENTITY, IDENTITY_QUAT, Pose, Quaternion, align_x, inverse, multiply, rotate, scale, unit
from wmspec.lang.check.ir.ir import Entity

_TYPES = {
    "hinge": "PhysicsRevoluteJoint",
    "slider": "PhysicsPrismaticJoint",
    "ball": "PhysicsSphericalJoint",
    "fixed": "PhysicsFixedJoint",
}
#: Kinds with one coordinate: the drive's token, and USD units per SI unit.
_COORDINATES = {"hinge": ("angular", 180 / math.pi), "slider": ("linear", 1.0)}


def joint_path(name: str) -> str:
    """Return the path of a joint's prim."""
    return f"/World/Joints/{name}"


def add_joint(doc: Document, joint: Entity, values: Evaluator, carried: Mapping[str, str]) -> None:
    """Add the prim of a joint whose objects are present. Raises WmsError with its location if it is invalid.

    `carried` maps each carried object to an action that carries it.
    """
    name = joint.name
    of, to = values.reference(name, "of"), values.reference(name, "to") if values.has(name, "to") else None
    sources = (f"{name}.present", f"{name}.of", f"{name}.to", f"{of}.present", *((f"{to}.present",) if to else ()))
    if not all(map(values.is_present, (name, of, to) if to else (name, of))):
        return
    if values.flag(of, "fixed"):
        raise ImpossibleValue(
            f"`{of}` is fixed, so no joint can move it", values.source_location(name, "of"), "exchange `of` and `to`"
        )
    if of == to:
        raise ImpossibleValue(f"the joint `{name}` joins `{of}` to itself", values.source_location(name, "to"))
    for end in (of, to):
        if end and end in carried:
            raise ImpossibleValue(
                f"`{end}` is carried by `{carried[end]}`, so the joint `{name}` cannot hold it",
                joint.place,
                "leave one of the two out, or let a joint to the world with a drive move it",
            )
    if "/World/Joints" not in doc.prims:
        doc.add("/World/Joints", "Scope", (), sources)
    driven = has_drive(joint, values)
    schemas = (f"PhysicsDriveAPI:{_COORDINATES[joint.model][0]}",) if driven else ()
    prim = doc.add(joint_path(name), _TYPES[joint.model], schemas, (*sources, *_drive_sources(name)))
    frame = Pose(values.vector(name, "at"), _frame(joint, values))
    for number, body in enumerate((to, of)):
        _set_body(prim, number, joint, body, frame, values)
    if values.has(name, "touching") and values.flag(name, "touching"):
        prim.set("physics:collisionEnabled", "bool", True, f"{name}.touching")
    if joint.model in _COORDINATES:
        _coordinate(prim, joint, values, driven)


def require_no_loops(values: Evaluator) -> None:
    """Raise WmsError with its location for a joint that closes a loop: engines solve trees."""
    groups: dict[str, set[str]] = {}
    for joint in values.spec.things:
        if joint.kind != "joint" or not values.is_present(joint.name):
            continue
        ends = values.ends(joint.name)
        if not all(map(values.is_present, ends)):
            continue
        of, to = (*("" if values.flag(end, "fixed") else end for end in ends), "")[:2]  # "" is the world
        first, second = groups.setdefault(of, {of}), groups.setdefault(to, {to})
        if of in ("", to):
            continue  # reported for the joint itself
        if first is second:
            tied = f"joins `{of}` and `{to}`" if of and to else f"holds `{of or to}` to the world"
            raise ImpossibleValue(
                f"`{joint.name}` {tied}, which other joints do already, and joints cannot form loops",
                joint.place,
                "remove one of them",
            )
        first |= second
        groups.update(dict.fromkeys(second, first))


def has_joint(values: Evaluator, owner: str) -> bool:
    """Whether a joint holds an object."""
    joints = (j.name for j in values.spec.things if j.kind == "joint" and values.is_present(j.name))
    ends = ((name, end) for name in joints for end in ("of", "to"))
    return any(values.reference(name, end) == owner for name, end in ends if values.has(name, end))


def has_drive(joint: Entity, values: Evaluator) -> bool:
    """Whether a joint has a drive, whose target an action can change. A drive with damping only brakes the joint."""
    if joint.model not in _COORDINATES:
        return False
    stiffness, damping = (values.number(joint.name, name) for name in ("stiffness", "damping"))
    if values.has(joint.name, "target") and stiffness == 0:
        place = values.source_location(joint.name, "target")
        raise ImpossibleValue(f"nothing takes `{joint.name}` to its target, as its stiffness is 0", place)
    return stiffness > 0 or damping > 0


def _set_body(prim: Prim, number: int, joint: Entity, body: str | None, frame: Pose, values: Evaluator) -> None:
    """Set one of the two bodies (or the world), and the joint's frame relative to it."""
    name = joint.name
    here = _place(joint, body, values)
    near = body or joint.of
    sources = (f"{name}.at", f"{name}.axis", *((f"{near}.pose",) if near else ()))
    ends = (f"{name}.of", f"{name}.to")
    if body:
        prim.relate(f"physics:body{number}", object_path(body), ends[1 - number])
    turn = multiply(inverse(here.orientation), frame.orientation)
    prim.set(f"physics:localPos{number}", "point3f", here.inverse_apply(frame.position), *sources, *ends)
    prim.set(f"physics:localRot{number}", "quatf", turn, *sources, *ends)


def _place(joint: Entity, body: str | None, values: Evaluator) -> Pose:
    """Return the pose of a body in the joint's space: the world, or the asset's frame with all joints at 0."""
    if not joint.of:
        return values.pose(body) if body else IDENTITY
    if body:
        return assets.zero_pose(values, body)
    frame = placement.frame(values, joint.of)
    return Pose(rotate(inverse(frame.orientation), scale(-1.0, frame.position)), inverse(frame.orientation))


def _frame(joint: Entity, values: Evaluator) -> Quaternion:
    """Return the rotation of the joint's frame, whose x axis is the joint's axis."""
    if joint.model not in _COORDINATES:
        return IDENTITY_QUAT
    axis = values.vector(joint.name, "axis")
    if math.hypot(*axis) < 1e-9:
        raise ImpossibleValue(
            f"the joint `{joint.name}` has no axis; it is 0 here", values.source_location(joint.name, "axis")
        )
    return align_x(unit(axis))


def _coordinate(prim: Prim, joint: Entity, values: Evaluator, driven: bool) -> None:
    name, (kind, scale) = joint.name, _COORDINATES[joint.model]
    prim.set("physics:axis", "token", "X", uniform=True)
    limits = {p: values.number(name, p) for p in ("low", "high") if values.has(name, p)}
    if limits.get("low", -math.inf) > limits.get("high", math.inf):
        raise ImpossibleValue(f"`low` of `{name}` is above its `high`", values.source_location(name, "low"))
    if not joint.of:  # joints of assets may start elsewhere; `assets` checks them
        help = "limits are counted from how its objects are placed, so 0 is between them"
        assets.require_within_limits(values, joint, 0.0, help)
    for side, attribute in (("low", "lowerLimit"), ("high", "upperLimit")):
        if side in limits:
            prim.set(f"physics:{attribute}", "float", limits[side] * scale, f"{name}.{side}")
    if values.has(name, "armature"):
        prim.set("newton:armature", "float", values.number(name, "armature"), f"{name}.armature")
    if driven:
        drive = f"drive:{kind}:physics"
        target = values.number(name, "target") if values.has(name, "target") else 0.0
        prim.set(f"{drive}:type", "token", "force", *_drive_sources(name), uniform=True)
        prim.set(f"{drive}:stiffness", "float", values.number(name, "stiffness") / scale, f"{name}.stiffness")
        prim.set(f"{drive}:damping", "float", values.number(name, "damping") / scale, f"{name}.damping")
        prim.set(f"{drive}:targetPosition", "float", target * scale, f"{name}.target")
        if values.has(name, "pace"):
            prim.set(f"{drive}:targetVelocity", "float", values.number(name, "pace") * scale, f"{name}.pace")
        if values.has(name, "strength"):
            prim.set(f"{drive}:maxForce", "float", values.number(name, "strength"), f"{name}.strength")


def _drive_sources(name: str) -> tuple[str, ...]:
    return (f"{name}.stiffness", f"{name}.damping", f"{name}.target")
