"""The part of a picture outside of which nothing depends on moving bodies.

It contains the boxes of moving bodies and their shadows. Shadows are searched among the points that a picture without
moving bodies shows.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import groupby

import numpy as np
from numpy.typing import NDArray

from wmspec.sim.scene.model import Array, Camera, Scene, Shot
from wmspec.sim.scene.model.transform import rotation
from wmspec.sim.scene.render.boxes import Boxes, ViewEdges
from wmspec.sim.scene.render.camera import look_at, project, unproject
from wmspec.sim.scene.render.shadow_culling import MAX_BLUR

WINDOW_MARGIN = 2
"""Pixels around visible content; multisampling and filters reach no further."""

TILE = 4
"""Pixels; texture levels are selected for 2 x 2 pixels and rasterization works on 4 x 4."""

SEARCH_STRIDE = 2
"""Sampling stride (pixels) when searching for shadowed pixels."""

MAX_BODIES_EXACT = 12
"""Above this number of bodies, one common box is searched for shadows."""


LitPoints = NDArray[np.float32]
"""Visible points (h, w, 3), m, in the axes of the sun; the last axis points against its light."""


@dataclass(frozen=True)
class Window:
    """The pixels `left` to `right` and `top` to `bottom` of a picture of `size` (width, height)."""

    left: int
    top: int
    right: int
    bottom: int
    size: tuple[int, int]

    @property
    def part(self) -> tuple[slice, slice]:
        """Its rows and columns."""
        return slice(self.top, self.bottom), slice(self.left, self.right)

    @property
    def width(self) -> int:
        """Width in pixels, 0 if empty."""
        return max(0, self.right - self.left)

    @property
    def height(self) -> int:
        """Height in pixels, 0 if empty."""
        return max(0, self.bottom - self.top)

    @property
    def share(self) -> float:
        """Fraction of the picture, 0..1."""
        return self.width * self.height / (self.size[0] * self.size[1])

    def edges(self, camera: Camera) -> ViewEdges:
        """Return the view edges of the window for a camera."""
        width, height = self.size
        focal = height / (2 * math.tan(camera.fovy / 2))
        across = (self.left - width / 2) / focal, (self.right - width / 2) / focal
        return *across, (height / 2 - self.bottom) / focal, (height / 2 - self.top) / focal


def full_window(width: int, height: int) -> Window:
    """Return the window of a whole picture."""
    return Window(0, 0, width, height, (width, height))


def _aligned(low: Array, high: Array, size: tuple[int, int]) -> Window:
    """Return the window around pixels `low` to `high` (x, y), extended to whole tiles.

    Filters that work on tiles then give the same result as in the whole picture. Tiles count from the lower left.
    """
    (left, top), (right, bottom) = low, high
    across = [math.floor(left / TILE) * TILE, math.ceil(right / TILE) * TILE]
    up = [math.ceil((size[1] - top) / TILE) * TILE, math.floor((size[1] - bottom) / TILE) * TILE]
    (left, right), (up, down) = np.clip(across, 0, size[0]), np.clip(up, 0, size[1])
    return Window(int(left), size[1] - int(up), int(right), size[1] - int(down), size)


class MovingBodies:
    """The movable bodies of a scene, precomputed."""

    def __init__(self, scene: Scene) -> None:
        self._chosen = [i for i, body in enumerate(scene.bodies) if body.motion != "static"]
        moving = tuple(scene.bodies[i] for i in self._chosen)
        self._boxes = Boxes(replace(scene, bodies=moving))
        self._axes = rotation(look_at(-scene.light.direction, np.zeros(3)).orientation)
        self._shadows = scene.light.shadows

    def lit(self, ids: NDArray[np.int16], depth: NDArray[np.float32], camera: Camera) -> LitPoints:
        """Return the points (h, w, 3) that a shadow may fall on, from `ids` and `depth` of a frame."""
        points = unproject(camera, depth)[::SEARCH_STRIDE, ::SEARCH_STRIDE] @ self._axes
        points[ids[::SEARCH_STRIDE, ::SEARCH_STRIDE] < 0] = np.inf  # background receives no shadow
        return points.astype(np.float32)

    def window(self, lit: LitPoints, camera: Camera, shot: Shot, size: tuple[int, int], texel: float) -> Window:
        """Return the window outside of which a picture (width, height) equals the one without moving bodies.

        `texel` (m) is the texel size of the shadow map.
        """
        if not self._boxes.count:
            return Window(0, 0, 0, 0, size)
        corners = self._boxes.corners(Shot(shot.camera, [shot.poses[i] for i in self._chosen]))
        places, depths = project(camera, corners.reshape(-1, 3), *size)
        if (depths < camera.near).any():
            return full_window(*size)
        spans = [(places.min(axis=0) - WINDOW_MARGIN, places.max(axis=0) + WINDOW_MARGIN)]
        if self._shadows:
            spans += self._shaded(lit, corners @ self._axes, MAX_BLUR * texel)
        low, high = np.min([low for low, _ in spans], axis=0), np.max([high for _, high in spans], axis=0)
        return _aligned(low, high, size)

    def _shaded(self, lit: LitPoints, corners: Array, edge: float) -> Iterator[tuple[Array, Array]]:
        """Yield pixel ranges (x, y) reached by shadows of boxes with these corners in the axes of the sun."""
        for low, high in self._columns(corners, edge):
            shaded = lit[..., 2] < high[2]
            for axis in (0, 1):
                shaded &= (lit[..., axis] > low[axis]) & (lit[..., axis] < high[axis])
            rows, columns = np.flatnonzero(shaded.any(axis=1)), np.flatnonzero(shaded.any(axis=0))
            if len(rows):
                first, last = np.array([columns[0], rows[0]]), np.array([columns[-1], rows[-1]])
                yield first * SEARCH_STRIDE - WINDOW_MARGIN, (last + 1) * SEARCH_STRIDE + WINDOW_MARGIN

    def _columns(self, corners: Array, edge: float) -> Iterator[tuple[Array, Array]]:
        """Yield lowest and highest corners (3,), in the axes of the sun, of each body, or of all if they are many."""
        numbers = [0] * len(corners) if len(self._chosen) > MAX_BODIES_EXACT else self._boxes.body
        for _, boxes in groupby(range(len(corners)), lambda i: numbers[i]):
            own = corners[list(boxes)].reshape(-1, 3)
            yield own.min(axis=0) - edge, own.max(axis=0) + edge
