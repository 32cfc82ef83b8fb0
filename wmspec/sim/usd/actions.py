"""Reads WmsAction: actions on bodies and joint drives.

Schema fallbacks are repeated here, because USD knows them only if the schema was registered before the first stage.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any

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
        return Steer(prim.GetName(), _driven(prim, joints), seconds(prim, "wms:start"), *make(prim, world))
    body, motion = single_target(prim, "wms:object", bodies, "rigid body"), MOTIONS[kind]
    if body.motion not in motion:
        required = " or ".join(motion)
        refuse(prim, f"{verb} needs a {required} body, but {body.path} is {body.motion}", f"choose a {required} body")
    made: Action = kind(prim.GetName(), body.name, seconds(prim, "wms:start"), *make(prim, world))
    return made


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


def _path(prim: Usd.Prim, world: StageFrame) -> tuple[Array, Array, Array | None]:
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
    return times, at, turned


def _place(prim: Usd.Prim, world: StageFrame) -> tuple[Array, Array | None]:
    turn = value(prim, "wms:orientation")
    return _vector(prim, "position", world), None if turn is None else _orientation(prim, turn, world)


def _color(prim: Usd.Prim) -> tuple[float, float, float]:
    red, green, blue = (float(part) for part in value(prim, "wms:color", Gf.Vec3d(0)))
    if not all(0 <= part <= 1 for part in (red, green, blue)):
        refuse(prim, f"wms:color = {(red, green, blue)}", "author sRGB in 0..1")
    return red, green, blue


def _pass_through(prim: Usd.Prim, bodies: Mapping[str, Body]) -> PassThrough:
    body: Body = single_target(prim, "wms:object", bodies, "rigid body")
    through: Body = single_target(prim, "wms:through", bodies, "rigid body")
    if body.motion == "static" or through.name == body.name:
        reason = f"{body.path} is {body.motion} and goes through {through.path}"
        refuse(prim, reason, "let a body that can move go through another one")
    return PassThrough(prim.GetName(), body.name, through.name, seconds(prim, "wms:start"), _stop(prim))


def _hold(prim: Usd.Prim, body: str, bodies: Mapping[str, Body]) -> Grip:
    hand: Body = single_target(prim, "wms:hand", bodies, "rigid body")
    points = np.array(value(prim, "wms:points", ()), np.float64).reshape(-1, 3)
    if hand.motion != "kinematic" or not len(points):
        reason = f"{hand.path} is {hand.motion}, and it has {len(points)} wms:points"
        refuse(prim, reason, "use a kinematic hand with 1 to 3 points")
    return Grip(prim.GetName(), body, hand.name, seconds(prim, "wms:start"), _stop(prim), points)


def _stop(prim: Usd.Prim) -> float:
    return seconds(prim, "wms:start") + seconds(prim, "wms:duration")


def _vector(prim: Usd.Prim, name: str, world: StageFrame) -> Array:
    return world.direction(value(prim, f"wms:{name}", Gf.Vec3d(0)))


VERBS: dict[str, tuple[type[Any], Callable[[Usd.Prim, StageFrame], tuple[Any, ...]]]] = {
    "launch": (Launch, lambda prim, world: (_velocity(prim, world), _vector(prim, "spin", world))),
    "glide": (Glide, lambda prim, world: (_stop(prim), _velocity(prim, world))),
    "follow": (Follow, _path),
    "teleport": (Teleport, _place),
    "impulse": (Impulse, lambda prim, world: (_vector(prim, "impulse", world),)),
    "force": (Force, lambda prim, world: (_stop(prim), _vector(prim, "force", world))),
    "release": (Release, lambda *_: ()),
    "drive": (Steer, lambda prim, _: (float(value(prim, "wms:target", 0.0)),)),
    "paint": (Paint, lambda prim, _: (_color(prim),)),
    "vanish": (Vanish, lambda *_: ()),
}
"""Verb -> action class, and the reader of its numbers after `start`."""

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
