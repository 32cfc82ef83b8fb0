"""Oriented boxes over time, and the boxes around an object's solids."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from wmspec.compile.layout.evaluator import Evaluator
from wmspec.compile.layout.geometry import pieces
from wmspec.compile.layout.solids import PlacedShape
from wmspec.compile.robots.arm import Array
from wmspec.compile.robots.planning import matrix
from wmspec.core.space import scale
from wmspec.sim.shapes.shape import AXES

_NEXT, _LAST = [1, 2, 0], [2, 0, 1]


@dataclass(frozen=True, eq=False)
class Box:
    """A box at n times: `center` (n, 3), `axes` (n, 3, 3) as columns, and half edges `half` (3,) m."""

    center: Array
    axes: Array
    half: Array

    def meets(self, other: Box, slack: float) -> NDArray[np.bool_]:
        """Return when (n,) two boxes overlap, by the separating axis test (S. Gottschalk, OBBTree, 1996, section 5)."""
        turn = np.swapaxes(self.axes, 1, 2) @ other.axes
        way = ((other.center - self.center)[:, None, :] @ self.axes)[:, 0]
        size, a, b = np.abs(turn), self.half - slack, other.half - slack
        faces = np.abs(way) > a + size @ b
        others = np.abs((way[:, None, :] @ turn)[:, 0]) > (a @ size) + b
        meets = np.asarray(~(faces.any(axis=1) | others.any(axis=1)))
        if not meets.any():
            return meets
        way, turn, size = way[meets], turn[meets], size[meets]
        i, j = _NEXT, _LAST
        edge = np.abs(way[:, j, None] * turn[:, i, :] - way[:, i, None] * turn[:, j, :])
        reach = a[i][:, None] * size[:, j, :] + a[j][:, None] * size[:, i, :]
        reach = reach + size[:, :, j] * b[i] + size[:, :, i] * b[j]
        meets[meets] = ~(edge > reach + 1e-9).any(axis=(1, 2))
        return meets


def box_between(frames: Array, corners: Array) -> Box:
    """Return the box between two corners (2, 3) in these frames."""
    middle = frames[:, :3, :3] @ corners.mean(axis=0) + frames[:, :3, 3]
    return Box(middle, frames[:, :3, :3], (corners[1] - corners[0]) / 2)


def part_boxes(values: Evaluator, name: str, frame: Array) -> Iterator[Box]:
    """Yield the boxes around the solids of an object with this frame (4, 4)."""
    for piece in pieces(values, name):
        yield box_between((frame @ matrix(piece.pose))[None], local_corners(piece))


def local_corners(piece: PlacedShape) -> Array:
    """Return the corners (2, 3) m of the box around a solid, in its own frame."""
    low = [-piece.solid.reach(scale(-1.0, axis)) for axis in AXES]
    high = [piece.solid.reach(axis) for axis in AXES]
    return np.array([low, high])
