"""Cached pictures of static bodies, on which moving bodies are drawn, and subsets of the bodies of a scene."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from wmspec.core.memoize import cached_on
from wmspec.sim.scene.model import Body, Camera, Scene, Shot
from wmspec.sim.scene.model.digest import digest
from wmspec.sim.scene.render.boxes import ViewEdges
from wmspec.sim.scene.render.near_plane import NearPlane
from wmspec.sim.scene.render.shadow import ShadowCasters, ShadowMapRegion
from wmspec.sim.scene.render.shadow_culling import ShadowCulling, VisibleSet
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


class BodySubset:
    """Data of a subset of bodies, computed once for a scene."""

    def __init__(self, scene: Scene, bodies: Sequence[int], aspect: float) -> None:
        """`aspect` is width / height of the pictures."""
        self.bodies = bodies
        some = replace(scene, bodies=tuple(scene.bodies[i] for i in bodies))
        chosen = set(bodies)
        shown = [i in chosen for i, body in enumerate(scene.bodies) for geom in body.geoms if geom.visible]
        self._shown = np.array(shown, dtype=bool)
        self._near, self._thrown, self._casters = NearPlane(some, aspect), ShadowCulling(some), ShadowCasters(some)

    def _own(self, shot: Shot) -> Shot:
        """Return the poses of the subset in a shot of the whole scene."""
        return Shot(shot.camera, [shot.poses[i] for i in self.bodies])

    def nearest(self, camera: Camera, shot: Shot) -> Camera:
        """Return the camera with its near plane as far away as the subset allows."""
        return self._near.before(camera, self._own(shot))

    def region(self, camera: Camera, shot: Shot) -> ShadowMapRegion:
        """Return the shadow map region of the subset."""
        return self._casters.region(camera, self._own(shot))

    def sight(self, camera: Camera, edges: ViewEdges, shot: Shot, texel: float) -> VisibleSet:
        """Return the visible set of the whole scene, restricted to the subset."""
        own = self._thrown.sight(camera, edges, self._own(shot), texel)
        seen, casts = np.zeros((2, len(self._shown)), dtype=bool)
        seen[self._shown], casts[self._shown] = own.seen, own.casts
        return VisibleSet(seen, casts)
