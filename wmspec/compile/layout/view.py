"""From which side pictures show a scene: what they have on the left and on the right, in front and behind."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from wmspec.core.space import add, rotate, times
from wmspec.lang.check.ir.evaluate import NoValue

if TYPE_CHECKING:
    from wmspec.compile.layout.values import Values

#: What points so little aside looks straight up or down.
UPRIGHT = 1e-6


def front(values: Values) -> int:
    """The way that all cameras look which are observed, to the nearest quarter turn: anticlockwise from +y, 0 to 3.

    0, the world's own front, if they look different ways or one of them rides.
    """
    cameras = {o.camera for o in values.spec.observations}
    if any(values.has(camera, "ride") for camera in cameras):
        return 0
    ways = {facing(values, camera) for camera in cameras}
    return ways.pop() if len(ways) == 1 else 0


def facing(values: Values, camera: str) -> int:
    """The way that a camera looks at the start, as `front` counts."""
    return round(gaze(values, camera)) % 4


def gaze(values: Values, viewer: str) -> float:
    """The way that a camera or an object looks at the start, in quarter turns anticlockwise from +y.

    An object looks along its own x; a camera that looks straight down, to its upper edge. Raises NoValue for an object
    that looks straight up or down.
    """
    if not values.has(viewer, "look_at"):
        ahead = rotate(values.pose(viewer).orientation, (1.0, 0.0, 0.0))
        if math.hypot(ahead[0], ahead[1]) <= UPRIGHT:
            raise NoValue(f"`{viewer}` looks straight up or down, so nothing is on its left")
        return quarters(ahead[0], ahead[1])
    ahead = add(values.vector(viewer, "look_at"), times(-1.0, values.vector(viewer, "at")))
    if math.hypot(ahead[0], ahead[1]) <= 1e-9 * math.hypot(*ahead):
        ahead = (0.0, 1.0, 0.0)
    if values.has(viewer, "ride"):
        ahead = rotate(values.pose(values.reference(viewer, "ride")).orientation, ahead)
    return quarters(ahead[0], ahead[1])


def quarters(x: float, y: float) -> float:
    """The quarter turns, anticlockwise from +y, to a direction on the ground."""
    return math.atan2(-x, y) / (math.pi / 2)


def seen(way: float, x: float, y: float) -> tuple[float, float]:
    """How far (m) to the right and to the back something is for who looks that way, from its x and y in the world."""
    whole = math.floor(way)
    for _ in range(whole % 4):  # exact where nothing is left over
        x, y = y, -x
    rest = (way - whole) * math.pi / 2
    sine, cosine = math.sin(rest), math.cos(rest)
    return (x * cosine + y * sine, y * cosine - x * sine) if rest else (x, y)
