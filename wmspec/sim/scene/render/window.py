"""A part of a picture, and the part outside of which nothing tells of what moves.

What moves is seen where its boxes are, and its shadow on what lies behind them along the sun: which of the points that
a picture without it shows do, is told by the distances of these.
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
from wmspec.sim.scene.render.boxes import Boxes, Edges
from wmspec.sim.scene.render.camera import look_at, project, unproject
from wmspec.sim.scene.render.shadow_culling import BLURRED

EDGE = 2
"""Pixels around what is seen in a window: samples of a pixel and filters reach no farther."""

BLOCK = 4
"""Pixels; levels of textures are chosen for two by two at once, and pixels are drawn by four by four."""

STEP = 2
"""Of the pixels in which a shadow may lie, every so manieth is looked at."""

MANY = 12
"""More bodies than this are taken together where their shadows are looked for."""


Lit = NDArray[np.float32]
"""Points that a picture shows (h, w, 3): metres in the sun's axes, the last one against its light."""


@dataclass(frozen=True)
class Window:
    """The pixels from `left` to `right` and from `top` to `bottom` of a picture, `size` is its (width, height)."""

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
        """In pixels; 0 if there is nothing in it."""
        return max(0, self.right - self.left)

    @property
    def height(self) -> int:
        """In pixels; 0 if there is nothing in it."""
        return max(0, self.bottom - self.top)

    @property
    def share(self) -> float:
        """How much of the picture it is, 0..1."""
        return self.width * self.height / (self.size[0] * self.size[1])

    def edges(self, camera: Camera) -> Edges:
        """Where a camera's pictures have it, at a depth of 1 m."""
        width, height = self.size
        focal = height / (2 * math.tan(camera.fovy / 2))
        across = (self.left - width / 2) / focal, (self.right - width / 2) / focal
        return *across, (height / 2 - self.bottom) / focal, (height / 2 - self.top) / focal


def full(width: int, height: int) -> Window:
    """All of a picture."""
    return Window(0, 0, width, height, (width, height))


def _aligned(low: Array, high: Array, size: tuple[int, int]) -> Window:
    """The window around places (x, y) from `low` to `high` whose corners are those of blocks that engines draw at once.

    What they filter by blocks is then the same as in the whole picture. Blocks are counted from the lower left.
    """
    (left, top), (right, bottom) = low, high
    across = [math.floor(left / BLOCK) * BLOCK, math.ceil(right / BLOCK) * BLOCK]
    up = [math.ceil((size[1] - top) / BLOCK) * BLOCK, math.floor((size[1] - bottom) / BLOCK) * BLOCK]
    (left, right), (up, down) = np.clip(across, 0, size[0]), np.clip(up, 0, size[1])
    return Window(int(left), size[1] - int(up), int(right), size[1] - int(down), size)


class Moving:
    """What moves in a scene; made once, asked for every shot."""

    def __init__(self, scene: Scene) -> None:
        self._chosen = [i for i, body in enumerate(scene.bodies) if body.motion != "static"]
        moving = tuple(scene.bodies[i] for i in self._chosen)
        self._boxes = Boxes(replace(scene, bodies=moving))
        self._axes = rotation(look_at(-scene.light.direction, np.zeros(3)).orientation)
        self._shadows = scene.light.shadows

    def lit(self, ids: NDArray[np.int16], depth: NDArray[np.float32], camera: Camera) -> Lit:
        """The points that a picture (h, w) shows, which a shadow may fall on, by what a `Frame` has."""
        points = unproject(camera, depth)[::STEP, ::STEP] @ self._axes
        points[ids[::STEP, ::STEP] < 0] = np.inf  # there is nothing to be shaded
        return points.astype(np.float32)

    def window(self, lit: Lit, camera: Camera, shot: Shot, size: tuple[int, int], texel: float) -> Window:
        """Outside of it a picture (width, height) is as `lit`, where nothing moves; `texel` (m) is the sun's map's."""
        if not self._boxes.count:
            return Window(0, 0, 0, 0, size)
        corners = self._boxes.corners(Shot(shot.camera, [shot.poses[i] for i in self._chosen]))
        places, depths = project(camera, corners.reshape(-1, 3), *size)
        if (depths < camera.near).any():
            return full(*size)
        spans = [(places.min(axis=0) - EDGE, places.max(axis=0) + EDGE)]
        if self._shadows:
            spans += self._shaded(lit, corners @ self._axes, BLURRED * texel)
        low, high = np.min([low for low, _ in spans], axis=0), np.max([high for _, high in spans], axis=0)
        return _aligned(low, high, size)

    def _shaded(self, lit: Lit, corners: Array, edge: float) -> Iterator[tuple[Array, Array]]:
        """From where to where (x, y) in the picture the shadows reach of boxes with these corners in the sun's axes."""
        for low, high in self._columns(corners, edge):
            shaded = lit[..., 2] < high[2]
            for axis in (0, 1):
                shaded &= (lit[..., axis] > low[axis]) & (lit[..., axis] < high[axis])
            rows, columns = np.flatnonzero(shaded.any(axis=1)), np.flatnonzero(shaded.any(axis=0))
            if len(rows):
                yield (
                    np.array([columns[0] * STEP - EDGE, rows[0] * STEP - EDGE]),
                    np.array([columns[-1] * STEP + STEP + EDGE, rows[-1] * STEP + STEP + EDGE]),
                )

    def _columns(self, corners: Array, edge: float) -> Iterator[tuple[Array, Array]]:
        """The lowest and highest corners (3,) in the sun's axes of each body, or of all if they are many."""
        numbers = [0] * len(corners) if len(self._chosen) > MANY else self._boxes.body
        for _, boxes in groupby(range(len(corners)), lambda i: numbers[i]):
            own = corners[list(boxes)].reshape(-1, 3)
            yield own.min(axis=0) - edge, own.max(axis=0) + edge
