"""Cached pictures of static bodies, on which moving bodies are drawn."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from wmspec.core.memoize import cached_on
from wmspec.sim.scene.model import Body, Camera, Scene, Shot
from wmspec.sim.scene.model.digest import digest
from wmspec.sim.scene.render.window import LitPoints, Window

MAX_BACKDROPS = 24
"""Each takes 12 bytes per pixel: 0.8 MB at 256 x 256."""


@dataclass(frozen=True)
class ImageLayer:
    """A picture or a window of one, with ids and depth as in a `Frame`."""

    rgb: NDArray[np.uint8]
    ids: NDArray[np.int16]
    depth: NDArray[np.float32]

    def over(self, window: Window, other: ImageLayer) -> ImageLayer:
        """Return this layer with another one in a window of it."""
        rgb, ids, depth = self.rgb.copy(), self.ids.copy(), self.depth.copy()
        rgb[window.part], ids[window.part], depth[window.part] = other.rgb, other.ids, other.depth
        return ImageLayer(rgb, ids, depth)

    def counted(self, bodies: Sequence[int]) -> ImageLayer:
        """Return the layer with ids relative to `bodies`, independent of the scene."""
        return replace(self, ids=np.where(self.ids < 0, -1, np.searchsorted(bodies, self.ids)).astype(np.int16))

    def numbered(self, bodies: Sequence[int]) -> ImageLayer:
        """Return the layer with scene ids of ids relative to `bodies`."""
        return replace(self, ids=np.array([*bodies, -1], np.int16).take(self.ids))


@dataclass(frozen=True)
class Backdrop:
    """Static bodies, with relative ids, and the points that may receive shadows of moving bodies."""

    layer: ImageLayer
    lit: LitPoints


def key(scene: Scene, bodies: Sequence[int], eye: Camera, shot: Shot, size: tuple[int, int]) -> bytes:
    """Return a hash of everything that a picture (width, height) of `bodies` shows; the camera is in the world."""
    looks = [cached_on(scene.bodies[i], _look) for i in bodies]
    poses = [(shot.poses[i].position, shot.poses[i].orientation) for i in bodies]
    lens = eye.pose.position, eye.pose.orientation, eye.fovy, eye.near, eye.far
    return digest(looks, poses, scene.light, scene.background, lens, size)


def _look(body: Body) -> bytes:
    return digest([(geom.shape, geom.pose, geom.surface) for geom in body.geoms if geom.visible])
