"""The near plane that a shot is drawn with: as far away as what the camera sees allows.

Engines keep depths as floats of the near plane's distance divided by the depth: with a near plane at 5 cm, what is 4 m
away is known to a tenth of a millimetre, with one at 1.6 m to a few micrometres.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from wmspec.sim.scene.model import Array, Camera, Scene, Shot
from wmspec.sim.scene.render.boxes import Boxes, edges, frustum

MARGIN = 0.95
"""The near plane lies before what is seen by the rest of this."""


class NearPlane:
    """Of a scene; made once, asked for every shot."""

    def __init__(self, scene: Scene, aspect: float) -> None:
        """`aspect` is the width of the pictures divided by their height."""
        self._boxes, self._aspect = Boxes(scene), aspect

    def before(self, camera: Camera, shot: Shot) -> Camera:
        """The `camera`, in the world, with its near plane doubled as often as leaves it before all that is seen."""
        nearest = min(self._nearest(camera, shot), camera.far)
        doublings = math.floor(math.log2(max(MARGIN * nearest / camera.near, 1.0)))
        return replace(camera, near=camera.near * 2**doublings)

    def _nearest(self, camera: Camera, shot: Shot) -> float:
        """Along the view axis, all that is in the picture is at least so far away (m)."""
        boxes = self._boxes.placed(shot, camera.pose.position)
        planes = frustum(camera, edges(camera, self._aspect))
        middle, reach = boxes.middle @ planes.T, boxes.reach(planes)
        seen = (middle + reach > 0).all(axis=1)
        beside: Array = np.maximum(np.abs(np.einsum("nij,ni->nj", boxes.turn, boxes.middle)) - boxes.half, 0)
        away = np.maximum((middle - reach)[:, 0], np.linalg.norm(beside, axis=1) * self._corner(camera))
        return float(away[seen].min(initial=math.inf))

    def _corner(self, camera: Camera) -> float:
        """The cosine of the angle between a camera's axis and the corners of its picture."""
        up = math.tan(camera.fovy / 2)
        return 1 / math.hypot(1, up, up * self._aspect)
