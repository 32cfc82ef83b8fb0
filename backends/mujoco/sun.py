"""Soft shadows from MuJoCo's shadow map.

MuJoCo compares one texel of its map with each pixel, which leaves stair steps. Here the map is read back, and pixels
of a picture without shadows are darkened by the share of the map that shades them.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from wmspec.sim.scene.model import Array, Camera, Light
from wmspec.sim.scene.model.transform import rotation
from wmspec.sim.scene.render.picture import Image, quantize
from wmspec.sim.scene.render.shadow import SUN_SHADE, ShadowMapRegion
from wmspec.sim.scene.render.shadow_filter import deciding_texels, occlusion
from wmspec.sim.scene.render.surfaces import rays, surfaces
from wmspec.sim.scene.render.window import Window


@dataclass(frozen=True)
class SunMap:
    """MuJoCo's map of what the sun sees: `texels` (n, n), 1 at the near plane and 0 at the far plane (m)."""

    texels: NDArray[np.float32]
    region: ShadowMapRegion
    near: float
    far: float

    def shade(
        self,
        rgb: NDArray[np.uint8],
        ids: NDArray[np.int16],
        depth: NDArray[np.float32],
        camera: Camera,
        light: Light,
        window: Window,
    ) -> NDArray[np.uint8]:
        """Return a window of a picture (h, w, 3), drawn without shadows, with the shadows of the sun."""
        x, y, away = self._places(depth, camera, light, window)
        rows, columns = (deciding_texels(at, len(self.texels)) for at in (y, x))
        shaded = occlusion(x, y, away, self._distances(rows, columns), (rows.start, columns.start))
        shaded[ids < 0] = 0
        down, across = np.flatnonzero(shaded.any(axis=1)), np.flatnonzero(shaded.any(axis=0))
        if not len(down):
            return rgb
        part = slice(down[0], down[-1] + 1), slice(across[0], across[-1] + 1)
        lost = _lost(ids, depth, camera, light, window, part) * shaded[part]
        picture = rgb.copy()
        picture[part] = quantize(rgb[part] * (1 - lost[..., None]))
        return picture

    def _distances(self, rows: slice, columns: slice) -> NDArray[np.float32]:
        """Return distances (m, n) of texels from the near plane (m), `inf` where nothing is."""
        texels = self.texels[rows, columns]
        distance = (1 - texels) * np.float32(self.far - self.near)
        return np.where(texels > 0, distance, np.float32(np.inf))

    def _places(
        self, depth: NDArray[np.float32], camera: Camera, light: Light, window: Window
    ) -> tuple[Image, Image, Image]:
        """Return columns, rows and distances from the near plane (m) of visible points in the map, (h, w) each."""
        axes = _axes(light.direction)
        eye = self.region.center - light.direction * self.region.reach
        turn = (rotation(camera.pose.orientation).T @ axes).astype(np.float32)
        move = ((camera.pose.position - eye) @ axes).astype(np.float32)
        x, y = rays(camera, window.size[::-1])
        x, y = x[window.part[1]], y[window.part[0]]
        right, up, away = (
            depth * (x * a + (y * b - c)[:, None]) + d for (a, b, c), d in zip(turn.T, move, strict=True)
        )
        scale, middle = np.float32(len(self.texels) / (2 * self.region.half)), np.float32(len(self.texels) / 2)
        return right * scale + middle, up * scale + middle, away - np.float32(self.near)


def _axes(direction: Array) -> Array:
    """Return the axes of MuJoCo's map in the world as columns: right, up, along the light."""
    aside = np.array([1.0, 0.0, 0.0])
    up = np.cross(aside, direction)
    up /= np.linalg.norm(up)
    return np.stack([np.cross(direction, up), up, direction], axis=1)


def _lost(
    ids: NDArray[np.int16],
    depth: NDArray[np.float32],
    camera: Camera,
    light: Light,
    window: Window,
    part: tuple[slice, slice],
) -> Image:
    """Return the fraction of light (h, w), 0..1, that the surfaces in a part of a window lose without the sun."""
    whole = np.full(window.size[::-1], -1, np.int16), np.zeros(window.size[::-1], np.float32)
    rows, columns = (
        slice(at.start + side.start, at.start + side.stop) for at, side in zip(window.part, part, strict=True)
    )
    whole[0][window.part], whole[1][window.part] = ids, depth
    _, normals = surfaces(camera, *whole, (rows, columns))
    sun = (-light.direction @ rotation(camera.pose.orientation)).astype(np.float32)
    facing = np.maximum(sum(n * s for n, s in zip(normals, sun, strict=True)), np.float32(0))
    direct = facing * np.float32(light.diffuse)
    lost: Image = np.float32(SUN_SHADE) * direct / np.maximum(direct + np.float32(light.ambient), np.float32(1e-6))
    return lost.reshape(rows.stop - rows.start, columns.stop - columns.start)
