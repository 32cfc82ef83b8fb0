"""Which shapes a camera may see, or the shadow that they throw: no others need to be drawn.

Shapes are known by their boxes. What one may shade lies behind its box along the sun, down to the lowest thing that is
in the picture; if that is wholly outside the picture, so is its shadow. Ground on which all stands shades nothing.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from wmspec.sim.scene.model import Array, Camera, Scene, Shot
from wmspec.sim.scene.render.boxes import Boxes, Edges, frustum
from wmspec.sim.shapes.box import Box

#: Shadows are blurred over so many texels of the sun's map, at most.
BLURRED = 4
#: How far (m) shadows may reach where the sun is lower than this (rise per way).
FAR, LOW = 1000.0, 0.05
#: What stands on the ground may be so far (m) in it: what lies below it is not seen.
SUNK = 0.005

_UP = np.array([[0.0, 0.0, 1.0]])


@dataclass(frozen=True)
class Sight:
    """Of every visible shape, in order, `seen` (n,) if it or its shadow may be, `casts` (n,) if it may throw one."""

    seen: NDArray[np.bool_]
    casts: NDArray[np.bool_]


class Thrown:
    """Of a scene; made once, asked for every shot."""

    def __init__(self, scene: Scene) -> None:
        self._boxes = Boxes(scene)
        self._sun = scene.light.direction / np.linalg.norm(scene.light.direction)
        shapes = [geom.shape for body in scene.bodies for geom in body.geoms if geom.visible]
        self._solid = np.array([isinstance(shape, Box) for shape in shapes], dtype=bool)

    def sight(self, camera: Camera, edges: Edges, shot: Shot, texel: float) -> Sight:
        """What the `camera`, in the world, may see within the `edges`.

        `texel` is the width (m) of a texel of the sun's map.
        """
        boxes = self._boxes.placed(shot, camera.pose.position)
        planes = frustum(camera, edges)
        inside: Array = boxes.middle @ planes.T + boxes.reach(planes)
        drawn = np.all(inside > 0, axis=1)
        if not drawn.any():
            return Sight(drawn, drawn)
        height, reach = boxes.middle[:, 2], boxes.reach(_UP)[:, 0]
        bottom, top = height - reach, height + reach
        lowest = float(bottom[drawn].min())
        fall = (top - lowest) / -self._sun[2] if self._sun[2] < -LOW else np.full(len(height), FAR)
        shaded = inside + np.maximum(planes @ self._sun, 0) * np.maximum(fall, 0)[:, None]
        seen = np.all(shaded > -BLURRED * texel, axis=1)
        return Sight(seen, seen & ~self._ground(bottom, top, drawn))

    def _ground(self, bottom: Array, top: Array, drawn: NDArray[np.bool_]) -> NDArray[np.bool_]:
        """Which boxes all else that is drawn stands on: they can shade nothing."""
        lowest = np.flatnonzero(drawn)[bottom[drawn].argmin()]
        ground = drawn & self._solid & (np.abs(top - top[lowest]) <= SUNK)
        above = bottom[drawn & ~ground].min(initial=np.inf) + SUNK
        return ground if ground[lowest] and top[lowest] <= above else np.zeros_like(ground)
