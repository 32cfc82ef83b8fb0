"""Viewing directions: left, right, front and back of a scene in its pictures."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from wmspec.core.space import add, rotate, scale
from wmspec.lang.check.ir.evaluate import NoValue

if TYPE_CHECKING:
    from wmspec.compile.layout.evaluator import Evaluator

#: A direction with a smaller horizontal component points straight up or down.
MIN_HORIZONTAL = 1e-6


def common_direction(values: Evaluator) -> int:
    """Return the common viewing direction of all observed cameras, in quarter turns (0..3) anticlockwise from +y.

    0, the world's own front, if cameras differ or one of them rides on an object.
    """
    cameras = {o.camera for o in values.spec.observations}
    if any(values.has(camera, "ride") for camera in cameras):
        return 0
    ways = {camera_direction(values, camera) for camera in cameras}
    return ways.pop() if len(ways) == 1 else 0


def camera_direction(values: Evaluator, camera: str) -> int:
    """Return the initial viewing direction of a camera, in quarter turns as in `common_direction`."""
    return round(gaze_direction(values, camera)) % 4


def gaze_direction(values: Evaluator, viewer: str) -> float:
    """Return the initial viewing direction of a camera or an object, in quarter turns anticlockwise from +y.

    An object looks along its x axis. For a camera that looks straight down it is the direction of its upper edge.
    Raises NoValue for an object that looks straight up or down.
    """
    if not values.has(viewer, "look_at"):
        ahead = rotate(values.pose(viewer).orientation, (1.0, 0.0, 0.0))
        if math.hypot(ahead[0], ahead[1]) <= MIN_HORIZONTAL:
            raise NoValue(f"`{viewer}` looks straight up or down, so nothing is on its left")
        return quarter_turns(ahead[0], ahead[1])
    ahead = add(values.vector(viewer, "look_at"), scale(-1.0, values.vector(viewer, "at")))
    if math.hypot(ahead[0], ahead[1]) <= 1e-9 * math.hypot(*ahead):
        ahead = (0.0, 1.0, 0.0)
    if values.has(viewer, "ride"):
        ahead = rotate(values.pose(values.reference(viewer, "ride")).orientation, ahead)
    return quarter_turns(ahead[0], ahead[1])


def quarter_turns(x: float, y: float) -> float:
    """Return the quarter turns, anticlockwise from +y, to a horizontal direction."""
    return math.atan2(-x, y) / (math.pi / 2)


def view_coordinates(way: float, x: float, y: float) -> tuple[float, float]:
    """Return the distances (m) to the right and to the back, seen along `way`, of world coordinates x and y."""
    whole = math.floor(way)
    for _ in range(whole % 4):  # exact for whole quarter turns
        x, y = y, -x
    rest = (way - whole) * math.pi / 2
    sine, cosine = math.sin(rest), math.cos(rest)
    return (x * cosine + y * sine, y * cosine - x * sine) if rest else (x, y)
