"""Gravity, and the schemas WmsEpisode and WmsObservation; `actions` reads WmsAction.

Schema fallbacks are repeated here, because USD knows them only if the schemas were registered before the first stage.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np
from pxr import Gf, Usd

from wmspec.core.safe_io import is_file_name
from wmspec.sim.scene.model import Array, Camera, Observation
from wmspec.sim.usd.frames import StageFrame
from wmspec.sim.usd.prims import refuse, seconds, single_target, value
from wmspec.sim.usd.schema import FORMAT_VERSION
from wmspec.sim.usd.substitutions import STRICT, Substitutions

STANDARD_GRAVITY = 9.81
"""Gravity as rounded by UsdPhysics, m/s²: the meaning of a negative physics:gravityMagnitude."""


def gravity(scenes: Sequence[Usd.Prim], world: StageFrame, notes: Substitutions = STRICT) -> Array:
    """Return the gravitational acceleration (3,), m/s².

    Raises: StageError: if there are several physics scenes, or gravity is infinite.
    """
    if not scenes:
        return STANDARD_GRAVITY * _DOWN
    here = _gravity(scenes[0], world)
    for extra in scenes[1:]:
        reason, remedy = "only one PhysicsScene is supported", "deactivate the others"
        if not np.allclose(_gravity(extra, world), here):
            refuse(extra, reason, remedy)
        notes.record(extra, reason, "all bodies use the first one, which has the same gravity", remedy)
    return here


_DOWN = np.array((0.0, 0.0, -1.0))


def _gravity(scene: Usd.Prim, world: StageFrame) -> Array:
    magnitude = float(value(scene, "physics:gravityMagnitude", -math.inf))
    if magnitude == math.inf:
        refuse(scene, "physics:gravityMagnitude = inf", "author a finite number, or a negative one for the Earth's")
    direction = Gf.Vec3d(value(scene, "physics:gravityDirection", Gf.Vec3f(0)))
    size = STANDARD_GRAVITY if magnitude < 0 else magnitude * world.meters
    return size * (world.direction(direction.GetNormalized()) if direction.GetLength() > 0 else _DOWN)


def timing(episodes: Sequence[Usd.Prim]) -> tuple[str, float, int]:
    """Return task name, duration (s) and rate (Hz); no name and duration 0 without an episode.

    Raises: StageError: if there are several episodes, or a newer version wrote it.
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
    if task and not all(map(is_file_name, str(task).split("/"))):
        refuse(prim, f"wms:task = {str(task)[:80]!r} is not a valid name", "write a name such as collide")
    return task, seconds(prim, "wms:duration"), rate


def observation(prim: Usd.Prim, cameras: Mapping[str, Camera]) -> Observation:
    """Return the prescribed pictures; `cameras` by path."""
    times = tuple(float(t) for t in value(prim, "wms:times", ()))
    if not all(0 <= t < math.inf for t in times):
        refuse(prim, f"wms:times = {list(times)}", "expected times of at least 0 s")
    return Observation(prim.GetName(), single_target(prim, "wms:camera", cameras, "camera").name, times)
