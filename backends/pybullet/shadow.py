"""Shadows for TinyRenderer, whose own have fixed strength and a fixed, absolute bias and come from a near point.

A shadow map as anywhere else (Williams, "Casting curved shadows on curved surfaces", SIGGRAPH 1978): TinyRenderer
draws the depth that the sun sees, and each visible point is compared with it.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from wmspec.sim.scene.model import Array, Camera
from wmspec.sim.scene.model.transform import rotation
from wmspec.sim.scene.render.camera import look_at, rays
from wmspec.sim.scene.render.picture import Image
from wmspec.sim.scene.render.shadow import Region

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
        """How much of the points seen by `camera` lies in shadow (h, w): 0..1, smooth over a texel of the map.

        `depth` (h, w) of the camera and `seen` (n, n) of the sun are along their view axes in metres; a depth of 0 is
        background, and not in shadow.
        """
        right, up, back = self._points(camera, depth)
        focal = np.float32(len(seen) / (2 * math.tan(ANGLE / 2)))
        middle, bias = np.float32(len(seen) / 2), np.float32(BIAS * 2 * self._half / len(seen))
        behind = _behind(middle - focal * right / back, middle + focal * up / back, -back - bias, seen)
        return np.where(depth > 0, behind, np.float32(0))

    def _points(self, camera: Camera, depth: NDArray[np.float32]) -> list[Image]:
        """The points seen by `camera` along the sun's right, up and backwards, (h, w) each, in metres."""
        axes = rotation(self.camera.pose.orientation)
        turn = (rotation(camera.pose.orientation).T @ axes).astype(np.float32)
        move = ((camera.pose.position - self.camera.pose.position) @ axes).astype(np.float32)
        x, y = (side.astype(np.float32) for side in rays(camera, depth.shape[1], depth.shape[0]))
        return [depth * (x * a + (y * b - c)[:, None]) + d for (a, b, c), d in zip(turn.T, move, strict=True)]


def _behind(x: Image, y: Image, away: Image, seen: NDArray[np.float32]) -> Image:
    """Of the four texels (of n, n) around each place `x`, `y` (h, w) of the map, the share that is nearer than `away`.

    They count by their distance ("percentage closer filtering": Reeves et al., SIGGRAPH 1987); none is outside.
    """
    side = np.float32(len(seen))
    x, y = np.clip(x + np.float32(0.5), 0, side), np.clip(y + np.float32(0.5), 0, side)
    column, row = x.astype(np.intp), y.astype(np.intp)
    right, down = x - column.astype(np.float32), y - row.astype(np.float32)
    wide = len(seen) + 2
    texels, first = np.pad(seen, 1, constant_values=np.inf).ravel(), row * wide + column
    upper = (texels[first] < away) * (1 - right) + (texels[first + 1] < away) * right
    lower = (texels[first + wide] < away) * (1 - right) + (texels[first + wide + 1] < away) * right
    share: Image = upper * (1 - down) + lower * down
    return share
