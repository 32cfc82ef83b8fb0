"""Reads WmsAction: actions on bodies and joint drives.

Schema fallbacks are repeated here, because USD knows them only if the schema was registered before the first stage.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence

import numpy as np
from pxr import Gf, Usd

from wmspec.sim.scene.action_rules import MOTIONS
from wmspec.sim.scene.model import (
    Action,
    Array,
    Body,
    Follow,
    Force,
    Glide,
    Grip,
    Impulse,
    Joint,
    Launch,
    Paint,
    PassThrough,
    Release,
    Steer,
    Teleport,
    Vanish,
)
from wmspec.sim.scene.physics.paths import overlaps
from wmspec.sim.usd.frames import StageFrame, quaternion
from wmspec.sim.usd.prims import refuse, seconds, single_target, value


def action(prim: Usd.Prim, bodies: Mapping[str, Body], joints: Mapping[str, Joint], world: StageFrame) -> Action:
    """Return the action of a prim; `bodies` and `joints` by path.

    Raises: StageError: if the verb is unknown or the object does not support it.
    """
    verb = value(prim, "wms:verb", "launch")
    if verb == "pass_through":
        return _pass_through(prim, bodies)
    if verb == "hold":
        held: Body = single_target(prim, "wms:object", bodies, "rigid body")
        if held.motion != "dynamic":
            refuse(prim, f"{held.path} is {held.motion}", "hold a dynamic body")
        return _hold(prim, held.name, bodies)
    if verb not in VERBS:
        refuse(prim, f"the verb '{verb}' is unknown", f"expected one of: {', '.join(TOKENS)}")
    kind, make = VERBS[verb]
    if kind is Steer:
        return make(prim, _driven(prim, joints), world)
    body, motion = single_target(prim, "wms:object", bodies, "rigid body"), MOTIONS[kind]
    if body.motion not in motion:
        required = " or ".join(motion)
        refuse(prim, f"{verb} needs a {required} body, but {body.path} is {body.motion}", f"choose a {required} body")
    return make(prim, body.name, world)


def _driven(prim: Usd.Prim, joints: Mapping[str, Joint]) -> str:
    joint: Joint = single_target(prim, "wms:joint", joints, "joint")
    if joint.drive is None:
        refuse(prim, f"{joint.path} has no drive", "apply PhysicsDriveAPI to the joint")
    return joint.name


def overlapping(performed: Sequence[tuple[Usd.Prim, Action]], bodies: Sequence[Body]) -> None:
    """Refuse two actions that move one body at the same time."""
    prims = {id(action): prim for prim, action in performed}
    for first, second in overlaps([action for _, action in performed], bodies):
        reason = f"it starts while {prims[id(first)].GetPath()} still moves {second.body}"
        refuse(prims[id(second)], reason, "end one before the other starts")


def _launch(prim: Usd.Prim, body: str, world: StageFrame) -> Launch:
    spin = world.direction(value(prim, "wms:spin", Gf.Vec3d(0)))
    return Launch(prim.GetName(), body, seconds(prim, "wms:start"), _velocity(prim, world), spin)


def _glide(prim: Usd.Prim, body: str, world: StageFrame) -> Glide:
    start = seconds(prim, "wms:start")
    return Glide(prim.GetName(), body, start, start + seconds(prim, "wms:duration"), _velocity(prim, world))


def _follow(prim: Usd.Prim, body: str, world: StageFrame) -> Follow:
    times = np.array(value(prim, "wms:times", ()), np.float64)
    points, turns = value(prim, "wms:points", ()), value(prim, "wms:orientations", ())
    if len(points) != len(times) or len(turns) not in (0, len(times)) or len(times) < 2:
        reason = f"it has {len(times)} wms:times, {len(points)} wms:points and {len(turns)} wms:orientations"
        refuse(
            prim,
            reason,
            "author at least 2 times, the same number of points, and the same number of orientations or none",
        )
    if times[0] != 0 or not (np.diff(times) > 0).all():
        refuse(prim, f"wms:times = {times.tolist()}", "expected increasing times (s) from 0")
    if not math.isclose(seconds(prim, "wms:duration") or times[-1], times[-1], rel_tol=1e-9):
        refuse(prim, "wms:duration is not the last of wms:times", "author the same number for both")
    at = np.array([world.direction(point) for point in points])
    turned = np.array([_orientation(prim, turn, world) for turn in turns]) if len(turns) else None
    return Follow(prim.GetName(), body, seconds(prim, "wms:start"), times, at, turned)


def _teleport(prim: Usd.Prim, body: str, world: StageFrame) -> Teleport:
    at = world.direction(value(prim, "wms:position", Gf.Vec3d(0)))
    turn = value(prim, "wms:orientation")
    turned = None if turn is None else _orientation(prim, turn, world)
    return Teleport(prim.GetName(), body, seconds(prim, "wms:start"), at, turned)


def _impulse(prim: Usd.Prim, body: str, world: StageFrame) -> Impulse:
    impulse = world.direction(value(prim, "wms:impulse", Gf.Vec3d(0)))
    return Impulse(prim.GetName(), body, seconds(prim, "wms:start"), impulse)


def _force(prim: Usd.Prim, body: str, world: StageFrame) -> Force:
    start = seconds(prim, "wms:start")
    force = world.direction(value(prim, "wms:force", Gf.Vec3d(0)))
    return Force(prim.GetName(), body, start, start + seconds(prim, "wms:duration"), force)


def _release(prim: Usd.Prim, body: str, _world: StageFrame) -> Release:
    return Release(prim.GetName(), body, seconds(prim, "wms:start"))


def _paint(prim: Usd.Prim, body: str, _world: StageFrame) -> Paint:
    red, green, blue = (float(part) for part in value(prim, "wms:color", Gf.Vec3d(0)))
    if not all(0 <= part <= 1 for part in (red, green, blue)):
        refuse(prim, f"wms:color = {(red, green, blue)}", "author sRGB in 0..1")
    return Paint(prim.GetName(), body, seconds(prim, "wms:start"), (red, green, blue))


def _vanish(prim: Usd.Prim, body: str, _world: StageFrame) -> Vanish:
    return Vanish(prim.GetName(), body, seconds(prim, "wms:start"))


def _pass_through(prim: Usd.Prim, bodies: Mapping[str, Body]) -> PassThrough:
    body: Body = single_target(prim, "wms:object", bodies, "rigid body")
    through: Body = single_target(prim, "wms:through", bodies, "rigid body")
    if body.motion == "static" or through.name == body.name:
        reason = f"{body.path} is {body.motion} and goes through {through.path}"
        refuse(prim, reason, "let a body that can move go through another one")
    start = seconds(prim, "wms:start")
    return PassThrough(prim.GetName(), body.name, through.name, start, start + seconds(prim, "wms:duration"))


def _hold(prim: Usd.Prim, body: str, bodies: Mapping[str, Body]) -> Grip:
    hand: Body = single_target(prim, "wms:hand", bodies, "rigid body")
    points = np.array(value(prim, "wms:points", ()), np.float64).reshape(-1, 3)
    if hand.motion != "kinematic" or not len(points):
        reason = f"{hand.path} is {hand.motion}, and it has {len(points)} wms:points"
        refuse(prim, reason, "use a kinematic hand with 1 to 3 points")
    start = seconds(prim, "wms:start")
    return Grip(prim.GetName(), body, hand.name, start, start + seconds(prim, "wms:duration"), points)


def _steer(prim: Usd.Prim, joint: str, _world: StageFrame) -> Steer:
    return Steer(prim.GetName(), joint, seconds(prim, "wms:start"), float(value(prim, "wms:target", 0.0)))


VERBS: dict[str, tuple[type[Action], Callable[[Usd.Prim, str, StageFrame], Action]]] = {
    "launch": (Launch, _launch),
    "glide": (Glide, _glide),
    "follow": (Follow, _follow),
    "teleport": (Teleport, _teleport),
    "impulse": (Impulse, _impulse),
    "force": (Force, _force),
    "release": (Release, _release),
    "drive": (Steer, _steer),
    "paint": (Paint, _paint),
    "vanish": (Vanish, _vanish),
}
"""Verb -> action class and its reader, which receives the name of the body or joint."""

TOKENS = (*VERBS, "pass_through", "reach", "hold")
"""All verbs of a stage: those above, and those that involve several bodies."""


def _orientation(prim: Usd.Prim, turn: Gf.Quatd, world: StageFrame) -> Array:
    """Return a quaternion of stage axes in world axes."""
    if not math.isclose(turn.GetLength(), 1.0, abs_tol=1e-6):
        refuse(prim, f"its orientation {turn} is no unit quaternion", "author quaternions of length 1")
    return quaternion(world.upright.ExtractRotationQuat() * turn)


def _velocity(prim: Usd.Prim, world: StageFrame) -> Array:
    speed, direction = float(value(prim, "wms:speed", 0.0)), Gf.Vec3d(value(prim, "wms:direction", Gf.Vec3d(0)))
    if not 0 <= speed < math.inf:
        refuse(prim, f"wms:speed = {speed:g}", "expected a speed of at least 0 m/s; reverse wms:direction instead")
    if speed and not math.isclose(direction.GetLength(), 1.0, abs_tol=1e-6):
        refuse(prim, f"wms:direction = {tuple(direction)} is no unit vector", "author a direction of length 1")
    return speed * world.direction(direction)
