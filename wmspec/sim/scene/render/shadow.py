"""Where the sun's shadow map must look: the same for all engines, fitted to what casts shadows.

A map that is seen along the sun needs to cover only what *casts*; whatever lies behind in the same column receives
the shadow, and everything beside it is lit. So it is fitted to the bodies of the shot, and ground is left out: a
static body so large, or so near the camera, that the camera is inside its bounding sphere. So are marks: static
decoration thinner than 5 mm, whose shadow nobody sees but which may be long.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from wmspec.core.memoize import cached_on
from wmspec.sim.scene.model import Array, Body, Camera, Scene, Shot
from wmspec.sim.scene.model.transform import rotation
from wmspec.sim.scene.render.boxes import shown
from wmspec.sim.scene.render.camera import look_at
from wmspec.sim.shapes.facets import tessellate

SHADE = 0.6
"""The share of the sun's light that shadows take away; the rest stands for light from the sky, and falls everywhere."""


@dataclass(frozen=True)
class Region:
    """A column along the sun: `center` (3,) in the world, `half` its half width (m), `reach` its half length (m).

    `casts` (N,) tells which bodies cast shadows; it was fitted to these.
    """

    center: Array
    half: float
    reach: float
    casts: NDArray[np.bool_]

    def same(self, other: Region) -> bool:
        """Whether it is the same column, whatever was in it."""
        at = np.array_equal(self.center, other.center)
        return at and (self.half, self.reach) == (other.half, other.reach)


class Casters:
    """The bounding spheres of a scene's bodies; made once, asked for every shot."""

    def __init__(self, scene: Scene) -> None:
        self._scene = scene
        self._radius = np.array([cached_on(body, _radius) for body in scene.bodies])
        self._axes = rotation(look_at(-scene.light.direction, np.zeros(3)).orientation)

        self._moves = np.array([body.motion != "static" for body in scene.bodies], dtype=bool)

    def size(self, body: int) -> float:
        """The radius of the sphere around a body's origin that holds it (m)."""
        return float(self._radius[body])

    def region(self, camera: Camera, shot: Shot) -> Region:
        """The column to draw the shadows of a shot in."""
        at = np.array([pose.position for pose in shot.poses]).reshape(-1, 3)
        away = np.linalg.norm(at - camera.pose.position, axis=1)
        casts = (self._radius > 0) & ((self._radius < away) | self._moves)
        if not casts.any():
            return Region(np.zeros(3), 1.0, 1.0 + float(np.linalg.norm(camera.pose.position)), casts)
        return self._around(at, casts, camera)

    def _around(self, at: Array, casts: NDArray[np.bool_], camera: Camera) -> Region:
        local, radius = at[casts] @ self._axes, self._radius[casts, None]
        middle = ((local - radius).min(axis=0) + (local + radius).max(axis=0)) / 2
        # a circle, since engines turn their square maps around the sun's direction as they like
        half = float((np.linalg.norm((local - middle)[:, :2], axis=1) + radius[:, 0]).max())
        thick = float((np.abs(local - middle)[:, 2] + radius[:, 0]).max())
        center: Array = self._axes @ middle
        reach = 2 * max(half, thick) + float(np.linalg.norm(camera.pose.position - center))
        return Region(center, 1.02 * half, reach, casts)


def _is_mark(body: Body) -> bool:
    """Whether a body is static decoration of a few millimetres, such as a line on the floor."""
    visible = (geom for geom in body.geoms if geom.visible)
    thin = all(np.ptp(tessellate(geom.shape).points, axis=0).min() < 0.005 for geom in visible)
    return body.motion == "static" and thin and not any(geom.collides for geom in body.geoms)


def _radius(body: Body) -> float:
    """The radius of the sphere around the body's origin that holds all that's visible of it (m), 0 for a mark."""
    if _is_mark(body):
        return 0.0
    return max((float(np.linalg.norm(points, axis=1).max()) for points in shown(body)), default=0.0)
