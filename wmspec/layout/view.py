"""From which side pictures show a scene: what they have on the left and on the right, in front and behind."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from wmspec.space import add, rotate, times

if TYPE_CHECKING:
    from wmspec.layout.values import Values


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
    """The way that a camera looks at the start, as `front` counts; of one that looks straight down, its upper edge."""
    ahead = add(values.property(camera, "look_at"), times(-1.0, values.property(camera, "at")))
    if math.hypot(ahead[0], ahead[1]) <= 1e-9 * math.hypot(*ahead):
        ahead = (0.0, 1.0, 0.0)
    if values.has(camera, "ride"):
        ahead = rotate(values.pose(values.property(camera, "ride")).orientation, ahead)
    return round(math.atan2(-ahead[0], ahead[1]) / (math.pi / 2)) % 4


def seen(way: int, x: float, y: float) -> tuple[float, float]:
    """How far (m) to the right and to the back something is for who looks that way, from its x and y in the world."""
    for _ in range(way):
        x, y = y, -x
    return x, y
