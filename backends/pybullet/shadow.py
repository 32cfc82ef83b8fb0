"""Shadows for TinyRenderer, whose own have fixed strength and a fixed, absolute bias and come from a near point.

A shadow map as anywhere else (Williams, "Casting curved shadows on curved surfaces", SIGGRAPH 1978): TinyRenderer
draws the depth that the sun sees, and each visible point is compared with it.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from wmspec.scene.camera import look_at, unproject, view_matrix
from wmspec.scene.model import Array, Camera
from wmspec.scene.picture import Image
from wmspec.scene.shadow import Region

ANGLE = math.radians(1.0)
"""The sun's map is seen under this angle from far away: its rays are nearly parallel."""

BIAS = 2.0
"""How many texels of the map a point must lie behind the caster."""


class Sun:
    """The sun as a camera that sees a region."""

    def __init__(self, region: Region, direction: Array) -> None:
        away = region.half / math.tan(ANGLE / 2)
        pose = look_at(region.center - direction * away, region.center)
        near, far = max(away - region.reach, away / 2), away + region.reach
        self.camera = Camera("sun", pose, ANGLE, near, far)
        self._half = region.half

    def occlusion(self, camera: Camera, depth: NDArray[np.float32], seen: NDArray[np.float32]) -> Image:
        """Which of the points seen by `camera` lie in shadow: 1.0 or 0.0 (h, w).

        `depth` (h, w) of the camera and `seen` (n, n) of the sun are along their view axes in metres.
        """
        side = len(seen)
        view = view_matrix(self.camera.pose).astype(np.float64)
        points = unproject(camera, depth) @ view[:3, :3].T + view[:3, 3]
        away = -points[..., 2]
        focal = side / (2 * math.tan(ANGLE / 2))
        with np.errstate(all="ignore"):
            column = np.floor(side / 2 + focal * points[..., 0] / away).astype(np.int64)
            row = np.floor(side / 2 - focal * points[..., 1] / away).astype(np.int64)
        inside = (column >= 0) & (column < side) & (row >= 0) & (row < side) & (depth > 0)
        nearest = seen[np.where(inside, row, 0), np.where(inside, column, 0)]
        behind = away - nearest > BIAS * 2 * self._half / side
        return (inside & behind).astype(np.float32)
