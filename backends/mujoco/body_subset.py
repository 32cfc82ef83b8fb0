"""A subset of the bodies of a scene with its near plane, shadow region and visible shapes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from wmspec.sim.scene.model import Camera, Scene, Shot
from wmspec.sim.scene.render.boxes import ViewEdges
from wmspec.sim.scene.render.near_plane import NearPlane
from wmspec.sim.scene.render.shadow import ShadowCasters, ShadowMapRegion
from wmspec.sim.scene.render.shadow_culling import ShadowCulling, VisibleSet


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
