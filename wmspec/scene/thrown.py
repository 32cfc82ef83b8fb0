"""Which shapes a camera may see, or the shadow that they throw: no others need to be drawn.

Shapes are known by their boxes. What one may shade lies behind its box along the sun, down to the lowest thing that is
in the picture; if that is wholly outside the picture, so is its shadow.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from wmspec.scene.bounds import upright
from wmspec.scene.kept import kept
from wmspec.scene.model import Array, Body, Camera, Scene, Shot
from wmspec.scene.transform import identity, rotation

#: Shadows are blurred over so many texels of the sun's map, at most.
BLURRED = 4
#: How far (m) shadows may reach where the sun is lower than this (rise per way).
FAR, LOW = 1000.0, 0.05

_UP = np.array([[0.0, 0.0, 1.0]])


class Thrown:
    """The boxes of a scene's visible shapes; made once, asked for every shot."""

    def __init__(self, scene: Scene, aspect: float) -> None:
        """`aspect` is the width of the pictures divided by their height."""
        shown = [kept(body, _boxes) for body in scene.bodies]
        boxes = np.concatenate([np.empty((0, 2, 3)), *shown])
        self._body = [i for i, own in enumerate(shown) for _ in own]
        self._middle, self._half = boxes.mean(axis=1), (boxes[:, 1] - boxes[:, 0]) / 2
        self._sun = scene.light.direction / np.linalg.norm(scene.light.direction)
        self._aspect = aspect

    def seen(self, camera: Camera, shot: Shot, texel: float) -> NDArray[np.bool_]:
        """Of every visible shape, in order, whether the `camera`, in the world, may see it or its shadow.

        `texel` is the width (m) of a texel of the sun's map.
        """
        turn = rotation(np.array([shot.poses[i].orientation for i in self._body]).reshape(-1, 4))
        place: Array = np.array([shot.poses[i].position for i in self._body]).reshape(-1, 3)
        middle: Array = place + np.einsum("nij,nj->ni", turn, self._middle)
        planes = self._frustum(camera)
        inside: Array = (middle - camera.pose.position) @ planes.T + self._reach(turn, planes)
        drawn: NDArray[np.bool_] = np.asarray(np.all(inside > 0, axis=1))
        if not drawn.any():
            return drawn
        reach = self._reach(turn, _UP)[:, 0]
        lowest = float((middle[:, 2] - reach)[drawn].min())
        fall = (middle[:, 2] + reach - lowest) / -self._sun[2] if self._sun[2] < -LOW else np.full(len(middle), FAR)
        shaded = inside + np.maximum(planes @ self._sun, 0) * np.maximum(fall, 0)[:, None]
        return np.asarray(np.all(shaded > -BLURRED * texel, axis=1))

    def _reach(self, turn: Array, normals: Array) -> Array:
        """How far (n, k) the boxes reach from their middles along normals (k, 3)."""
        reach: Array = np.einsum("nj,nkj->nk", self._half, np.abs(np.einsum("nij,ki->nkj", turn, normals)))
        return reach

    def _frustum(self, camera: Camera) -> Array:
        """The inward normals (5, 3) of the planes around what is seen."""
        up = math.tan(camera.fovy / 2)
        right = up * self._aspect
        planes = np.array([[0, 0, -1], [-1, 0, -right], [1, 0, -right], [0, -1, -up], [0, 1, -up]], dtype=np.float64)
        planes /= np.linalg.norm(planes, axis=1, keepdims=True)
        return planes @ rotation(camera.pose.orientation).T


def _boxes(body: Body) -> Array:
    """The boxes (n, 2, 3) m around a body's visible shapes, in its frame."""
    return np.array([upright((geom,), identity()) for geom in body.geoms if geom.visible]).reshape(-1, 2, 3)
