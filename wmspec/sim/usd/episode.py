"""What happens on the stage: gravity, and our own schemas WmsEpisode and WmsObservation; see `actions` for WmsAction.

The fallbacks of the schemas are repeated here, since USD knows them only if it met the schemas before its first stage.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np
from pxr import Gf, Usd

from wmspec.core.safe_io import is_name
from wmspec.sim.scene.model import Array, Camera, Observation
from wmspec.sim.usd.frames import World
from wmspec.sim.usd.prims import refuse, seconds, target, value
from wmspec.sim.usd.schema import FORMAT_VERSION
from wmspec.sim.usd.substitutions import STRICT, Notes

EARTH = 9.81
"""Standard gravity as UsdPhysics rounds it, m/s²: what a negative physics:gravityMagnitude means."""


def gravity(scenes: Sequence[Usd.Prim], world: World, notes: Notes = STRICT) -> Array:
    """The acceleration of free fall (3,), m/s².

    Raises:
        StageError: if there are several physics scenes, or gravity is endless.
    """
    if not scenes:
        return EARTH * _DOWN
    here = _gravity(scenes[0], world)
    for extra in scenes[1:]:
        reason, remedy = "only one PhysicsScene is supported", "deactivate the others"
        if not np.allclose(_gravity(extra, world), here):
            refuse(extra, reason, remedy)
        notes.instead(extra, reason, "all bodies are in the first one, which has the same gravity", remedy)
    return here


_DOWN = np.array((0.0, 0.0, -1.0))


def _gravity(scene: Usd.Prim, world: World) -> Array:
    magnitude = float(value(scene, "physics:gravityMagnitude", -math.inf))
    if magnitude == math.inf:
        refuse(scene, "physics:gravityMagnitude = inf", "author a finite number, or a negative one for the Earth's")
    direction = Gf.Vec3d(value(scene, "physics:gravityDirection", Gf.Vec3f(0)))
    size = EARTH if magnitude < 0 else magnitude * world.meters
    return size * (world.direction(direction.GetNormalized()) if direction.GetLength() > 0 else _DOWN)


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
    task = value(prim, "wms:task", "")
    if task and not all(map(is_name, str(task).split("/"))):
        refuse(prim, f"wms:task = {str(task)[:80]!r} is no name", "write a name such as collide")
    return task, seconds(prim, "wms:duration"), rate


def observation(prim: Usd.Prim, cameras: Mapping[str, Camera]) -> Observation:
    """The pictures to take; `cameras` by their paths."""
    times = tuple(float(t) for t in value(prim, "wms:times", ()))
    if not all(0 <= t < math.inf for t in times):
        refuse(prim, f"wms:times = {list(times)}", "expected times of at least 0 s")
    return Observation(prim.GetName(), target(prim, "wms:camera", cameras, "camera").name, times)
