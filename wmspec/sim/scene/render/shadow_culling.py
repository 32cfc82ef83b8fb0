"""Visibility culling: shapes that neither appear in a picture nor cast a shadow into it are not drawn.

A box can shade the volume behind it along the sun, down to the lowest visible shape. If that volume is outside the
picture, so is its shadow. The ground on which everything stands shades nothing.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from wmspec.sim.scene.model import Array, Camera, Scene, Shot
from wmspec.sim.scene.render.boxes import Boxes, ViewEdges, frustum
from wmspec.sim.shapes.box import Box

#: Width of the shadow blur, in texels of the shadow map.
MAX_BLUR = 4
#: m: length of shadows if the sun is below `LOW_SUN` (rise over run).
MAX_SHADOW_LENGTH, LOW_SUN = 1000.0, 0.05
#: m: bodies may be sunk this deep in the ground.
MAX_SUNK = 0.005

_UP = np.array([[0.0, 0.0, 1.0]])


@dataclass(frozen=True)
class VisibleSet:
    """For each visible shape, `seen` (n,): it or its shadow may appear; `casts` (n,): it may cast a shadow."""

    seen: NDArray[np.bool_]
    casts: NDArray[np.bool_]


class ShadowCulling:
    """Culling data of a scene, computed once."""

    def __init__(self, scene: Scene) -> None:
        self._boxes = Boxes(scene)
        self._sun = scene.light.direction / np.linalg.norm(scene.light.direction)
        shapes = [geom.shape for body in scene.bodies for geom in body.geoms if geom.visible]
        self._solid = np.array([isinstance(shape, Box) for shape in shapes], dtype=bool)

    def sight(self, camera: Camera, edges: ViewEdges, shot: Shot, texel: float) -> VisibleSet:
        """Return the visible set of the world `camera` within `edges`.

        `texel` is the width (m) of a texel of the shadow map.
        """
        boxes = self._boxes.placed(shot, camera.pose.position)
        planes = frustum(camera, edges)
        inside: Array = boxes.middle @ planes.T + boxes.reach(planes)
        drawn = np.all(inside > 0, axis=1)
        if not drawn.any():
            return VisibleSet(drawn, drawn)
        height, reach = boxes.middle[:, 2], boxes.reach(_UP)[:, 0]
        bottom, top = height - reach, height + reach
        lowest = float(bottom[drawn].min())
        fall = (top - lowest) / -self._sun[2] if self._sun[2] < -LOW_SUN else np.full(len(height), MAX_SHADOW_LENGTH)
        shaded = inside + np.maximum(planes @ self._sun, 0) * np.maximum(fall, 0)[:, None]
        seen = np.all(shaded > -MAX_BLUR * texel, axis=1)
        return VisibleSet(seen, seen & ~self._ground(bottom, top, drawn))

    def _ground(self, bottom: Array, top: Array, drawn: NDArray[np.bool_]) -> NDArray[np.bool_]:
        """Return the boxes on which all other drawn shapes stand."""
        lowest = np.flatnonzero(drawn)[bottom[drawn].argmin()]
        ground = drawn & self._solid & (np.abs(top - top[lowest]) <= MAX_SUNK)
        above = bottom[drawn & ~ground].min(initial=np.inf) + MAX_SUNK
        return ground if ground[lowest] and top[lowest] <= above else np.zeros_like(ground)
