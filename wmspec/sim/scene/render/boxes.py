"""Bounding boxes of visible shapes in body frames, and their placement in pictures."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from wmspec.core.memoize import cached_on
from wmspec.sim.scene.model import Array, Body, Camera, Scene, Shot
from wmspec.sim.scene.model.transform import rotation
from wmspec.sim.shapes.facets import tessellate

ViewEdges = tuple[float, float, float, float]
"""Left, right, bottom and top of a view at a depth of 1 m, relative to the camera axis."""

_CORNERS = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], dtype=np.float64)


class Boxes:
    """Boxes of the visible shapes of a scene, computed once.

    `body` holds the number of the body of each box.
    """

    def __init__(self, scene: Scene) -> None:
        boxes = [cached_on(body, _boxes) for body in scene.bodies]
        self._middle, self._half, radius = np.concatenate([np.empty((0, 3, 3)), *boxes]).swapaxes(0, 1)
        self._radius = radius[:, 0]
        self.body = [i for i, own in enumerate(boxes) for _ in own]

    def placed(self, shot: Shot, eye: Array) -> PlacedBoxes:
        """Return the boxes of a shot in world axes, relative to `eye` (3,)."""
        poses = [shot.poses[body] for body in self.body]
        turn = rotation(np.array([pose.orientation for pose in poses]).reshape(-1, 4))
        place: Array = np.array([pose.position for pose in poses]).reshape(-1, 3)
        return PlacedBoxes(turn, place - eye + np.einsum("nij,nj->ni", turn, self._middle), self._half, self._radius)

    @property
    def count(self) -> int:
        """Number of boxes."""
        return len(self.body)

    def corners(self, shot: Shot) -> Array:
        """Return the corners (n, 8, 3) of the boxes in the world."""
        placed = self.placed(shot, np.zeros(3))
        half = placed.half[:, None] * _CORNERS
        corners: Array = placed.middle[:, None] + np.einsum("nij,nkj->nki", placed.turn, half)
        return corners


@dataclass(frozen=True)
class PlacedBoxes:
    """Boxes in world axes: rotations (n, 3, 3), centres and half edges (n, 3).

    `radius` (n,) bounds the distance of content from the centres.
    """

    turn: Array
    middle: Array
    half: Array
    radius: Array

    def reach(self, normals: Array) -> Array:
        """Return upper bounds (n, k) of the extent from the centres along unit normals (k, 3)."""
        along: Array = np.abs(np.einsum("nij,ki->nkj", self.turn, normals))
        return np.asarray(np.minimum(np.einsum("nj,nkj->nk", self.half, along), self.radius[:, None]))


def visible_points(body: Body) -> list[Array]:
    """Return the points (n, 3) m of the visible triangles of each geom, in the body frame."""
    return [
        geom.pose.position + tessellate(geom.shape).points @ rotation(geom.pose.orientation).T
        for geom in body.geoms
        if geom.visible
    ]


def view_edges(camera: Camera, aspect: float) -> ViewEdges:
    """Return the edges of the full view; `aspect` is width / height."""
    up = math.tan(camera.fovy / 2)
    return -up * aspect, up * aspect, -up, up


def frustum(camera: Camera, view_edges: ViewEdges) -> Array:
    """Return the inward normals (5, 3) of the planes around a view, the camera axis first."""
    left, right, down, up = view_edges
    planes = np.array([[0, 0, -1], [-1, 0, -right], [1, 0, left], [0, -1, -up], [0, 1, down]], dtype=np.float64)
    planes /= np.linalg.norm(planes, axis=1, keepdims=True)
    return planes @ rotation(camera.pose.orientation).T


def _boxes(body: Body) -> Array:
    """Return centres, half edges and radii of the boxes of a body: (n, 3, 3) m."""
    return np.array([_box(points) for points in visible_points(body)]).reshape(-1, 3, 3)


def _box(points: Array) -> tuple[Array, Array, Array]:
    low, high = points.min(axis=0), points.max(axis=0)
    middle = (low + high) / 2
    return middle, (high - low) / 2, np.full(3, np.linalg.norm(points - middle, axis=1).max())
