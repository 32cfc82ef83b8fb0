"""The near plane that a shot is drawn with: as far away as what the camera sees allows.

Engines keep depths as floats of the near plane's distance divided by the depth: with a near plane at 5 cm, what is 4 m
away is known to a tenth of a millimetre, with one at 1.6 m to a few micrometres.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from wmspec.scene.kept import kept
from wmspec.scene.model import Array, Body, Camera, Scene, Shot
from wmspec.scene.transform import rotation
from wmspec.shapes.facets import tessellate

MARGIN = 0.95
"""The near plane lies before what is seen by the rest of this."""


class NearPlane:
    """The boxes of a scene's bodies, each in its body's frame; made once, asked for every shot."""

    def __init__(self, scene: Scene, aspect: float) -> None:
        """`aspect` is the width of the pictures divided by their height."""
        shown = [kept(body, _boxes) for body in scene.bodies]
        self._body = [i for i, own in enumerate(shown) for _ in own]
        low, high = np.concatenate([np.empty((0, 2, 3)), *shown]).swapaxes(0, 1)
        self._middle, self._half = (low + high) / 2, (high - low) / 2
        self._aspect = aspect

    def before(self, camera: Camera, shot: Shot) -> Camera:
        """The `camera`, in the world, with its near plane doubled as often as leaves it before all that is seen."""
        nearest = min(self._nearest(camera, shot), camera.far)
        doublings = math.floor(math.log2(max(MARGIN * nearest / camera.near, 1.0)))
        return replace(camera, near=camera.near * 2**doublings)

    def _nearest(self, camera: Camera, shot: Shot) -> float:
        """Along the view axis, all that is in the picture is at least so far away (m)."""
        poses = [shot.poses[body] for body in self._body]
        turn = rotation(np.array([pose.orientation for pose in poses]).reshape(-1, 4))
        place: Array = np.array([pose.position for pose in poses]).reshape(-1, 3)
        to_middle: Array = place - camera.pose.position + np.einsum("nij,nj->ni", turn, self._middle)
        planes, corner = self._frustum(camera)
        # along each plane's normal, seen from the eye: the middle of each box, and how far the box reaches
        middle: Array = to_middle @ planes.T
        reach: Array = np.einsum("nj,nkj->nk", self._half, np.abs(np.einsum("nij,ki->nkj", turn, planes)))
        seen = (middle + reach > 0).all(axis=1)
        beside: Array = np.maximum(np.abs(np.einsum("nij,ni->nj", turn, to_middle)) - self._half, 0)
        away = np.maximum((middle - reach)[:, 0], np.linalg.norm(beside, axis=1) * corner)
        return float(away[seen].min(initial=math.inf))

    def _frustum(self, camera: Camera) -> tuple[Array, float]:
        """The inward normals (5, 3) of the planes around what is seen, the axis first; the cosine to its corners."""
        up = math.tan(camera.fovy / 2)
        right = up * self._aspect
        planes = np.array([[0, 0, -1], [-1, 0, -right], [1, 0, -right], [0, -1, -up], [0, 1, -up]], dtype=np.float64)
        return planes @ rotation(camera.pose.orientation).T, 1 / math.sqrt(1 + up * up + right * right)


def _boxes(body: Body) -> Array:
    """The boxes (n, 2, 3) m around a body's visible triangles, geometry by geometry, in its frame."""
    points = [
        geom.pose.position + tessellate(geom.shape).points @ rotation(geom.pose.orientation).T
        for geom in body.geoms
        if geom.visible
    ]
    return np.array([(one.min(axis=0), one.max(axis=0)) for one in points]).reshape(-1, 2, 3)
