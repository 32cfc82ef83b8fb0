"""Pictures of what stands still, on which others of the same place are drawn: most of a picture is like the last."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from wmspec.core.memoize import cached_on
from wmspec.sim.scene.model import Body, Camera, Scene, Shot
from wmspec.sim.scene.model.digest import digest
from wmspec.sim.scene.render.window import Lit, Window

REMEMBERED = 24
"""The most backdrops that are remembered. Each takes 12 bytes a pixel: 0.8 MB at 256 by 256."""


@dataclass(frozen=True)
class Layer:
    """A picture with distances, all of it or a window, as a `Frame` has them."""

    rgb: NDArray[np.uint8]
    ids: NDArray[np.int16]
    depth: NDArray[np.float32]

    def over(self, window: Window, other: Layer) -> Layer:
        """With another in a window of it."""
        rgb, ids, depth = self.rgb.copy(), self.ids.copy(), self.depth.copy()
        rgb[window.part], ids[window.part], depth[window.part] = other.rgb, other.ids, other.depth
        return Layer(rgb, ids, depth)

    def counted(self, bodies: Sequence[int]) -> Layer:
        """With bodies counted among these, in whatever scene they are."""
        return replace(self, ids=np.where(self.ids < 0, -1, np.searchsorted(bodies, self.ids)).astype(np.int16))

    def numbered(self, bodies: Sequence[int]) -> Layer:
        """With the numbers in the scene of bodies counted among these."""
        return replace(self, ids=np.array([*bodies, -1], np.int16).take(self.ids))


@dataclass(frozen=True)
class Backdrop:
    """What stands still, counted among itself, and the points of it that what moves may throw shadows on."""

    layer: Layer
    lit: Lit


def key(scene: Scene, bodies: Sequence[int], eye: Camera, shot: Shot, size: tuple[int, int]) -> bytes:
    """All that a picture (width, height) of some bodies of a scene shows; the camera is in the world."""
    looks = [cached_on(scene.bodies[i], _look) for i in bodies]
    poses = [(shot.poses[i].position, shot.poses[i].orientation) for i in bodies]
    lens = eye.pose.position, eye.pose.orientation, eye.fovy, eye.near, eye.far
    return digest(looks, poses, scene.light, scene.background, lens, size)


def _look(body: Body) -> bytes:
    return digest([(geom.shape, geom.pose, geom.surface) for geom in body.geoms if geom.visible])
