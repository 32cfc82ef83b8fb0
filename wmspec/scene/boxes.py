"""The boxes around what a scene shows, each in its body's frame, and where they are in a picture."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from wmspec.scene.kept import kept
from wmspec.scene.model import Array, Body, Camera, Scene, Shot
from wmspec.scene.transform import rotation
from wmspec.shapes.facets import tessellate


class Boxes:
    """The boxes of a scene's visible shapes, in order; made once, placed for every shot."""

    def __init__(self, scene: Scene) -> None:
        shown = [kept(body, _boxes) for body in scene.bodies]
        low, high = np.concatenate([np.empty((0, 2, 3)), *shown]).swapaxes(0, 1)
        self._body = [i for i, own in enumerate(shown) for _ in own]
        self._middle, self._half = (low + high) / 2, (high - low) / 2

    def placed(self, shot: Shot, eye: Array) -> Placed:
        """Where the boxes are in a shot, as seen from a point (3,) of the world."""
        poses = [shot.poses[body] for body in self._body]
        turn = rotation(np.array([pose.orientation for pose in poses]).reshape(-1, 4))
        place: Array = np.array([pose.position for pose in poses]).reshape(-1, 3)
        return Placed(turn, place - eye + np.einsum("nij,nj->ni", turn, self._middle), self._half)


@dataclass(frozen=True)
class Placed:
    """Boxes in the axes of the world: how they are turned (n, 3, 3), their middles and half their edges (n, 3)."""

    turn: Array
    middle: Array
    half: Array

    def reach(self, normals: Array) -> Array:
        """How far (n, k) they reach from their middles along normals (k, 3)."""
        along: Array = np.abs(np.einsum("nij,ki->nkj", self.turn, normals))
        return np.asarray(np.einsum("nj,nkj->nk", self.half, along))


def shown(body: Body) -> list[Array]:
    """The points (n, 3) m of a body's visible triangles, geometry by geometry, in its frame."""
    return [
        geom.pose.position + tessellate(geom.shape).points @ rotation(geom.pose.orientation).T
        for geom in body.geoms
        if geom.visible
    ]


def frustum(camera: Camera, aspect: float) -> Array:
    """The inward normals (5, 3) of the planes around what a camera sees, its axis first.

    `aspect` is the width of its pictures divided by their height.
    """
    up = math.tan(camera.fovy / 2)
    right = up * aspect
    planes = np.array([[0, 0, -1], [-1, 0, -right], [1, 0, -right], [0, -1, -up], [0, 1, -up]], dtype=np.float64)
    planes /= np.linalg.norm(planes, axis=1, keepdims=True)
    return planes @ rotation(camera.pose.orientation).T


def _boxes(body: Body) -> Array:
    """The lowest and highest corners (n, 2, 3) m of the boxes of a body."""
    return np.array([(one.min(axis=0), one.max(axis=0)) for one in shown(body)]).reshape(-1, 2, 3)
