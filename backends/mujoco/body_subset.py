"""Some of a scene's bodies, as they are drawn: from how near, with which of their shapes, in which light."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from wmspec.sim.scene.model import Camera, Scene, Shot
from wmspec.sim.scene.render.boxes import Edges
from wmspec.sim.scene.render.near_plane import NearPlane
from wmspec.sim.scene.render.shadow import Casters, Region
from wmspec.sim.scene.render.shadow_culling import Sight, Thrown


class Cast:
    """Made once of a scene and the numbers of some of its bodies; asked for every shot of the scene."""

    def __init__(self, scene: Scene, bodies: Sequence[int], aspect: float) -> None:
        """`aspect` is the width of the pictures divided by their height."""
        self.bodies = bodies
        some = replace(scene, bodies=tuple(scene.bodies[i] for i in bodies))
        chosen = set(bodies)
        shown = [i in chosen for i, body in enumerate(scene.bodies) for geom in body.geoms if geom.visible]
        self._shown = np.array(shown, dtype=bool)
        self._near, self._thrown, self._casters = NearPlane(some, aspect), Thrown(some), Casters(some)

    def _own(self, shot: Shot) -> Shot:
        """Where these bodies are in a shot of the whole scene."""
        return Shot(shot.camera, [shot.poses[i] for i in self.bodies])

    def nearest(self, camera: Camera, shot: Shot) -> Camera:
        """The camera with its near plane as far away as these bodies allow."""
        return self._near.before(camera, self._own(shot))

    def region(self, camera: Camera, shot: Shot) -> Region:
        """The column along the sun in which they throw their shadows."""
        return self._casters.region(camera, self._own(shot))

    def sight(self, camera: Camera, edges: Edges, shot: Shot, texel: float) -> Sight:
        """Of every visible shape of the scene: if it is theirs, and it or its shadow may be seen within the edges."""
        own = self._thrown.sight(camera, edges, self._own(shot), texel)
        seen, casts = np.zeros((2, len(self._shown)), dtype=bool)
        seen[self._shown], casts[self._shown] = own.seen, own.casts
        return Sight(seen, casts)
