"""The boxes around what a scene shows, each in its body's frame, and where they are in a picture."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from wmspec.core.memoize import cached_on
from wmspec.sim.scene.model import Array, Body, Camera, Scene, Shot
from wmspec.sim.scene.model.transform import rotation
from wmspec.sim.shapes.facets import tessellate

Edges = tuple[float, float, float, float]
"""How far what is seen reaches to the right of a camera's axis, from and to, and above it, at a depth of 1 m."""

_CORNERS = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], dtype=np.float64)


class Boxes:
    """The boxes of a scene's visible shapes, in order; made once, placed for every shot.

    `body` are the numbers of their bodies.
    """

    def __init__(self, scene: Scene) -> None:
        shown = [cached_on(body, _boxes) for body in scene.bodies]
        self._middle, self._half, radius = np.concatenate([np.empty((0, 3, 3)), *shown]).swapaxes(0, 1)
        self._radius = radius[:, 0]
        self.body = [i for i, own in enumerate(shown) for _ in own]

    def placed(self, shot: Shot, eye: Array) -> Placed:
        """Where the boxes are in a shot, as seen from a point (3,) of the world."""
        poses = [shot.poses[body] for body in self.body]
        turn = rotation(np.array([pose.orientation for pose in poses]).reshape(-1, 4))
        place: Array = np.array([pose.position for pose in poses]).reshape(-1, 3)
        return Placed(turn, place - eye + np.einsum("nij,nj->ni", turn, self._middle), self._half, self._radius)

    @property
    def count(self) -> int:
        """How many boxes there are."""
        return len(self.body)

    def corners(self, shot: Shot) -> Array:
        """The corners (n, 8, 3) of the boxes in the world."""
        placed = self.placed(shot, np.zeros(3))
        half = placed.half[:, None] * _CORNERS
        corners: Array = placed.middle[:, None] + np.einsum("nij,nkj->nki", placed.turn, half)
        return corners


@dataclass(frozen=True)
class Placed:
    """Boxes in the axes of the world: how they are turned (n, 3, 3), their middles and half their edges (n, 3).

    What is in them is no farther from their middles than `radius` (n,).
    """

    turn: Array
    middle: Array
    half: Array
    radius: Array

    def reach(self, normals: Array) -> Array:
        """How far (n, k) what is in them reaches from their middles along unit normals (k, 3), at most."""
        along: Array = np.abs(np.einsum("nij,ki->nkj", self.turn, normals))
        return np.asarray(np.minimum(np.einsum("nj,nkj->nk", self.half, along), self.radius[:, None]))


def shown(body: Body) -> list[Array]:
    """The points (n, 3) m of a body's visible triangles, geometry by geometry, in its frame."""
    return [
        geom.pose.position + tessellate(geom.shape).points @ rotation(geom.pose.orientation).T
        for geom in body.geoms
        if geom.visible
    ]


def edges(camera: Camera, aspect: float) -> Edges:
    """Of all that a camera sees; `aspect` is the width of its pictures divided by their height."""
    up = math.tan(camera.fovy / 2)
    return -up * aspect, up * aspect, -up, up


def frustum(camera: Camera, edges: Edges) -> Array:
    """The inward normals (5, 3) of the planes around what a camera sees within these edges, its axis first."""
    left, right, down, up = edges
    planes = np.array([[0, 0, -1], [-1, 0, -right], [1, 0, left], [0, -1, -up], [0, 1, down]], dtype=np.float64)
    planes /= np.linalg.norm(planes, axis=1, keepdims=True)
    return planes @ rotation(camera.pose.orientation).T


def _boxes(body: Body) -> Array:
    """The middles of the boxes of a body, half their edges, and how far what is in them is from there: (n, 3, 3) m."""
    return np.array([_box(points) for points in shown(body)]).reshape(-1, 3, 3)


def _box(points: Array) -> tuple[Array, Array, Array]:
    low, high = points.min(axis=0), points.max(axis=0)
    middle = (low + high) / 2
    return middle, (high - low) / 2, np.full(3, np.linalg.norm(points - middle, axis=1).max())
