"""The region of the sun's shadow map, equal for all engines and fitted to the bodies that cast shadows.

A map along the sun needs to cover shadow casters only: surfaces behind them in the same column receive the shadow, all
others are lit. Ground is left out: static bodies whose bounding sphere contains the camera. So are marks: static
decoration thinner than 5 mm.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from wmspec.core.memoize import cached_on
from wmspec.sim.scene.model import Array, Body, Camera, Scene, Shot
from wmspec.sim.scene.model.transform import rotation
from wmspec.sim.scene.render.boxes import visible_points
from wmspec.sim.scene.render.camera import look_at
from wmspec.sim.shapes.facets import tessellate

SUN_SHADE = 0.6
"""Fraction of light that a sun shadow removes; the rest is sky light."""


@dataclass(frozen=True)
class ShadowMapRegion:
    """A column along the sun: `center` (3,) in the world, half width `half` (m), half length `reach` (m).

    `casts` (N,): the bodies that cast shadows and determine the region.
    """

    center: Array
    half: float
    reach: float
    casts: NDArray[np.bool_]

    def same(self, other: ShadowMapRegion) -> bool:
        """Whether the columns are equal, independent of their bodies."""
        at = np.array_equal(self.center, other.center)
        return at and (self.half, self.reach) == (other.half, other.reach)


class ShadowCasters:
    """Bounding spheres of the bodies of a scene, computed once."""

    def __init__(self, scene: Scene) -> None:
        self._scene = scene
        self._radius = np.array([cached_on(body, _radius) for body in scene.bodies])
        self._axes = rotation(look_at(-scene.light.direction, np.zeros(3)).orientation)

        self._moves = np.array([body.motion != "static" for body in scene.bodies], dtype=bool)

    def size(self, body: int) -> float:
        """Return the radius (m) of the bounding sphere around a body's origin."""
        return float(self._radius[body])

    def region(self, camera: Camera, shot: Shot) -> ShadowMapRegion:
        """Return the shadow map region of a shot."""
        at = np.array([pose.position for pose in shot.poses]).reshape(-1, 3)
        away = np.linalg.norm(at - camera.pose.position, axis=1)
        casts = (self._radius > 0) & ((self._radius < away) | self._moves)
        if not casts.any():
            return ShadowMapRegion(np.zeros(3), 1.0, 1.0 + float(np.linalg.norm(camera.pose.position)), casts)
        return self._around(at, casts, camera)

    def _around(self, at: Array, casts: NDArray[np.bool_], camera: Camera) -> ShadowMapRegion:
        local, radius = at[casts] @ self._axes, self._radius[casts, None]
        middle = ((local - radius).min(axis=0) + (local + radius).max(axis=0)) / 2
        # a circle: engines rotate their square maps about the sun in different ways
        half = float((np.linalg.norm((local - middle)[:, :2], axis=1) + radius[:, 0]).max())
        thick = float((np.abs(local - middle)[:, 2] + radius[:, 0]).max())
        center: Array = self._axes @ middle
        reach = 2 * max(half, thick) + float(np.linalg.norm(camera.pose.position - center))
        return ShadowMapRegion(center, 1.02 * half, reach, casts)


def _is_mark(body: Body) -> bool:
    """Whether a body is static decoration of a few millimetres, such as a line on the floor."""
    visible = (geom for geom in body.geoms if geom.visible)
    thin = all(np.ptp(tessellate(geom.shape).points, axis=0).min() < 0.005 for geom in visible)
    return body.motion == "static" and thin and not any(geom.collides for geom in body.geoms)


def _radius(body: Body) -> float:
    """Return the radius (m) of the sphere around the body's origin that contains its visible shapes, 0 for a mark."""
    if _is_mark(body):
        return 0.0
    return max((float(np.linalg.norm(points, axis=1).max()) for points in visible_points(body)), default=0.0)
