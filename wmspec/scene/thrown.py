"""Which shapes a camera may see, or the shadow that they throw: no others need to be drawn.

Shapes are known by their boxes. What one may shade lies behind its box along the sun, down to the lowest thing that is
in the picture; if that is wholly outside the picture, so is its shadow.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from wmspec.scene.boxes import Boxes, frustum
from wmspec.scene.model import Array, Camera, Scene, Shot

#: Shadows are blurred over so many texels of the sun's map, at most.
BLURRED = 4
#: How far (m) shadows may reach where the sun is lower than this (rise per way).
FAR, LOW = 1000.0, 0.05

_UP = np.array([[0.0, 0.0, 1.0]])


class Thrown:
    """Of a scene; made once, asked for every shot."""

    def __init__(self, scene: Scene, aspect: float) -> None:
        """`aspect` is the width of the pictures divided by their height."""
        self._boxes, self._aspect = Boxes(scene), aspect
        self._sun = scene.light.direction / np.linalg.norm(scene.light.direction)

    def seen(self, camera: Camera, shot: Shot, texel: float) -> NDArray[np.bool_]:
        """Of every visible shape, in order, whether the `camera`, in the world, may see it or its shadow.

        `texel` is the width (m) of a texel of the sun's map.
        """
        boxes = self._boxes.placed(shot, camera.pose.position)
        planes = frustum(camera, self._aspect)
        inside: Array = boxes.middle @ planes.T + boxes.reach(planes)
        drawn: NDArray[np.bool_] = np.asarray(np.all(inside > 0, axis=1))
        if not drawn.any():
            return drawn
        height, reach = boxes.middle[:, 2], boxes.reach(_UP)[:, 0]
        lowest = float((height - reach)[drawn].min())
        fall = (height + reach - lowest) / -self._sun[2] if self._sun[2] < -LOW else np.full(len(height), FAR)
        shaded = inside + np.maximum(planes @ self._sun, 0) * np.maximum(fall, 0)[:, None]
        return np.asarray(np.all(shaded > -BLURRED * texel, axis=1))
