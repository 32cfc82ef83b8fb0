"""Shadow mapping for TinyRenderer, whose own shadows have fixed strength, an absolute bias and a near light.

A standard shadow map (Williams, "Casting curved shadows on curved surfaces", SIGGRAPH 1978): TinyRenderer draws the
depth seen from the sun, and each visible point is compared with it.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from wmspec.sim.scene.model import Array, Camera
from wmspec.sim.scene.model.transform import rotation
from wmspec.sim.scene.render.camera import look_at, pixel_rays
from wmspec.sim.scene.render.picture import Image
from wmspec.sim.scene.render.shadow import ShadowMapRegion
from wmspec.sim.scene.render.shadow_filter import occlusion

SUN_FOV = math.radians(1.0)
"""Field of view of the sun's map from far away: its rays are nearly parallel."""

SHADOW_BIAS = 2.0
"""Texels by which a shadowed point must lie behind the caster."""


class Sun:
    """The sun as a camera of a shadow region."""

    def __init__(self, region: ShadowMapRegion, direction: Array) -> None:
        away = region.half / math.tan(SUN_FOV / 2)
        pose = look_at(region.center - direction * away, region.center)
        near, far = max(away - region.reach, away / 2), away + region.reach
        self.camera = Camera("sun", pose, SUN_FOV, near, far)
        self._half = region.half

    def occlusion(self, camera: Camera, depth: NDArray[np.float32], seen: NDArray[np.float32]) -> Image:
        """Return the shadowed fraction (h, w), 0..1, of points seen by `camera`, smooth over two texels.

        `depth` (h, w) of the camera and `seen` (n, n) of the sun are along their view axes, m; depth 0 is background.
        """
        right, up, back = self._points(camera, depth)
        focal = np.float32(len(seen) / (2 * math.tan(SUN_FOV / 2)))
        middle, bias = np.float32(len(seen) / 2), np.float32(SHADOW_BIAS * 2 * self._half / len(seen))
        behind = occlusion(middle - focal * right / back, middle + focal * up / back, -back - bias, seen)
        return np.where(depth > 0, behind, np.float32(0))

    def _points(self, camera: Camera, depth: NDArray[np.float32]) -> list[Image]:
        """Return the points seen by `camera` along the sun's right, up and backward axes, (h, w) each, m."""
        axes = rotation(self.camera.pose.orientation)
        turn = (rotation(camera.pose.orientation).T @ axes).astype(np.float32)
        move = ((camera.pose.position - self.camera.pose.position) @ axes).astype(np.float32)
        x, y = (side.astype(np.float32) for side in pixel_rays(camera, depth.shape[1], depth.shape[0]))
        return [depth * (x * a + (y * b - c)[:, None]) + d for (a, b, c), d in zip(turn.T, move, strict=True)]
