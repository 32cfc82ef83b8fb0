"""Visible points and normals of a picture, from ids and depth."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from wmspec.sim.scene.model import Camera
from wmspec.sim.scene.render.camera import pixel_rays
from wmspec.sim.scene.render.picture import Image

ImageRegion = tuple[slice, slice]
"""Rows and columns of a picture."""


def surfaces(
    camera: Camera, ids: NDArray[np.int16], depth: NDArray[np.float32], window: ImageRegion
) -> tuple[list[Image], list[Image]]:
    """Return visible points and unit normals in a window, (n,) along each camera axis.

    The inverse depth of a plane is linear in pixel coordinates; its slopes give the normal.
    """
    x, y = rays(camera, ids.shape)
    step = x[1] - x[0] if len(x) > 1 else np.float32(1)
    ids, depth, x, y = ids[window], depth[window], x[window[1]], y[window[0]]
    near: Image = np.reciprocal(np.maximum(depth, np.float32(1e-6)))
    along, up = _slope(near, ids, 1) / step, -_slope(near, ids, 0) / step
    normal = [-along, -up, near - x * along - y[:, None] * up]
    length = np.sqrt(normal[0] ** 2 + normal[1] ** 2 + normal[2] ** 2)
    points = [x * depth, y[:, None] * depth, -depth]
    return [part.ravel() for part in points], [(part / length).ravel() for part in normal]


def rays(camera: Camera, size: tuple[int, ...]) -> tuple[Image, Image]:
    """Return `pixel_rays` for a picture (height, width)."""
    x, y = pixel_rays(camera, size[1], size[0])
    return x.astype(np.float32), y.astype(np.float32)


def _slope(values: Image, ids: NDArray[np.int16], axis: int) -> Image:
    """Return the difference of `values` (h, w) per pixel, towards the more similar neighbour of the same body."""
    step = np.where(np.diff(ids, axis=axis) == 0, np.diff(values, axis=axis), np.float32(np.inf))
    before, after = np.full_like(values, np.inf), np.full_like(values, np.inf)
    if axis:
        before[:, 1:] = after[:, :-1] = step
    else:
        before[1:] = after[:-1] = step
    slope = np.where(np.abs(before) < np.abs(after), before, after)
    slope[np.isinf(slope)] = 0
    return slope
