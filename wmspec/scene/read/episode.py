"""What happens on the stage: gravity, and our own schemas WmsEpisode, WmsAction and WmsObservation.

The fallbacks of the schemas are repeated here, since USD knows them only if it met the schemas before its first stage.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from itertools import pairwise
from typing import Any

import numpy as np
from pxr import Gf, Usd

from wmspec.scene.model import Action, Array, Body, Camera, Glide, Launch, Observation
from wmspec.scene.read.frames import World
from wmspec.scene.read.prims import refuse, targets, value
from wmspec.scene.schema import FORMAT_VERSION

EARTH = 9.81
"""Standard gravity as UsdPhysics rounds it, m/s²: what a negative physics:gravityMagnitude means."""


def gravity(scenes: Sequence[Usd.Prim], world: World) -> Array:
    """The acceleration of free fall (3,), m/s².

    Raises:
        StageError: if there are several physics scenes.
    """
    for extra in scenes[1:]:
        refuse(extra, "only one PhysicsScene is supported", "deactivate the others")
    down = np.array((0.0, 0.0, -1.0))
    if not scenes:
        return EARTH * down
    magnitude = float(value(scenes[0], "physics:gravityMagnitude", -math.inf))
    direction = Gf.Vec3d(value(scenes[0], "physics:gravityDirection", Gf.Vec3f(0)))
    size = EARTH if magnitude < 0 else magnitude * world.meters
    return size * (world.direction(direction.GetNormalized()) if direction.GetLength() > 0 else down)


def timing(episodes: Sequence[Usd.Prim]) -> tuple[str, float, int]:
    """The task's name, the duration (s) and the rate (Hz); no name and no duration if there is no episode.

    Raises:
        StageError: if there are several, or a newer version wrote it.
    """
    if not episodes:
        return "", 0.0, 240
    for extra in episodes[1:]:
        refuse(extra, "only one WmsEpisode is supported", "deactivate the others")
    prim = episodes[0]
    if (version := value(prim, "wms:formatVersion", FORMAT_VERSION)) > FORMAT_VERSION:
        refuse(prim, f"its wms:formatVersion is {version}, newer than {FORMAT_VERSION}", "use a newer wmspec")
    rate = int(value(prim, "wms:rate", 240))
    if rate <= 0:
        refuse(prim, f"wms:rate = {rate}", "expected a rate above 0")
    return str(value(prim, "wms:task", "")), _seconds(prim, "wms:duration"), rate


def action(prim: Usd.Prim, bodies: Mapping[str, Body], world: World) -> Action:
    """The action; `bodies` by their paths.

    Raises:
        StageError: if the verb is unknown, or the object can't do it.
    """
    verb = value(prim, "wms:verb", "launch")
    if verb not in VERBS:
        refuse(prim, f"the verb '{verb}' is unknown", f"expected one of: {', '.join(VERBS)}")
    motion, make = VERBS[verb]
    body = _target(prim, "wms:object", bodies, "rigid body")
    if body.motion != motion:
        refuse(prim, f"{verb} needs a {motion} body, but {body.path} is {body.motion}", f"choose a {motion} body")
    return make(prim, body, world)


def observation(prim: Usd.Prim, cameras: Mapping[str, Camera]) -> Observation:
    """The pictures to take; `cameras` by their paths."""
    times = tuple(float(t) for t in value(prim, "wms:times", ()))
    if not all(0 <= t < math.inf for t in times):
        refuse(prim, f"wms:times = {list(times)}", "expected times of at least 0 s")
    return Observation(prim.GetName(), _target(prim, "wms:camera", cameras, "camera").name, times)


def overlapping(glides: Sequence[tuple[Usd.Prim, Action]]) -> None:
    """Refuse two glides that move one body at the same time."""
    found = sorted(
        ((a.body, a.start, a.stop, prim) for prim, a in glides if isinstance(a, Glide)), key=lambda row: row[:3]
    )
    for (body, _, stop, _), (other, start, _, prim) in pairwise(found):
        if body == other and start < stop - 1e-9:
            refuse(prim, f"it starts while another glide still moves {body}", "let one end before the other starts")


def _launch(prim: Usd.Prim, body: Body, world: World) -> Launch:
    spin = world.direction(value(prim, "wms:spin", Gf.Vec3d(0)))
    return Launch(prim.GetName(), body.name, _seconds(prim, "wms:start"), _velocity(prim, world), spin)


def _glide(prim: Usd.Prim, body: Body, world: World) -> Glide:
    start = _seconds(prim, "wms:start")
    return Glide(prim.GetName(), body.name, start, start + _seconds(prim, "wms:duration"), _velocity(prim, world))


VERBS: dict[str, tuple[str, Callable[[Usd.Prim, Body, World], Action]]] = {
    "launch": ("dynamic", _launch),
    "glide": ("kinematic", _glide),
}
"""Verb -> the motion that its object must have, and what reads it."""


def _velocity(prim: Usd.Prim, world: World) -> Array:
    speed, direction = float(value(prim, "wms:speed", 0.0)), Gf.Vec3d(value(prim, "wms:direction", Gf.Vec3d(0)))
    if not 0 <= speed < math.inf:
        refuse(prim, f"wms:speed = {speed:g}", "expected a speed of at least 0 m/s; turn wms:direction round instead")
    if speed and not math.isclose(direction.GetLength(), 1.0, abs_tol=1e-6):
        refuse(prim, f"wms:direction = {tuple(direction)} is no unit vector", "author a direction of length 1")
    return speed * world.direction(direction)


def _seconds(prim: Usd.Prim, name: str) -> float:
    found = float(value(prim, name, 0.0))
    if not 0 <= found < math.inf:
        refuse(prim, f"{name} = {found:g}", "expected at least 0 s")
    return found


def _target(prim: Usd.Prim, name: str, known: Mapping[str, Any], what: str) -> Any:
    paths = targets(prim, name)
    if len(paths) != 1 or paths[0] not in known:
        refuse(prim, f"{name} -> {paths} is not one {what} of the stage", f"target the prim of one {what}")
    return known[paths[0]]
