"""Places and sizes of bodies in a picture, in pixels of a picture of 384 x 384."""

from __future__ import annotations

import numpy as np

from wmspec.core.memoize import cached_on
from wmspec.runtime.questions.legibility.bounds import REFERENCE_SIDE
from wmspec.runtime.questions.observed import Observed
from wmspec.runtime.questions.patch import patch
from wmspec.runtime.questions.views import View
from wmspec.sim.scene.model import Array, Frame, Shot
from wmspec.sim.scene.render.camera import project, world_camera

#: m: step of the numeric derivative of a projection.
_STEP = 1e-3


def scale(frame: Frame) -> float:
    """Return the pixels of a picture of 384 x 384 for a pixel of this picture."""
    height, width = frame.ids.shape
    return REFERENCE_SIDE / float(min(height, width))


def center(frame: Frame, index: int) -> Array | None:
    """Return the centre (2,) px of the drawn part of a body; None if none is drawn."""
    own = patch(frame, index)
    if own.across is None or own.down is None:
        return None
    height, width = frame.ids.shape
    return np.array([own.across * width, own.down * height]) * scale(frame)


def size(frame: Frame, index: int) -> float:
    """Return the geometric mean (px) of width and height of the drawn part of a body; 0 if none is drawn."""
    own = patch(frame, index)
    (top, bottom), (left, right) = own.rows, own.columns
    return float(np.sqrt((bottom - top + 1) * (right - left + 1))) * scale(frame)


def width_along(frame: Frame, index: int, way: Array) -> float:
    """Return the width (px) of the drawn part of a body along a direction (2,)."""
    along = (cached_on(frame, _pixels, index) @ way) / np.linalg.norm(way)
    return (float(np.ptp(along)) + 1) * scale(frame)


def _pixels(frame: Frame, index: int) -> Array:
    """Return the columns and rows (n, 2) of the pixels of a body."""
    return np.argwhere(frame.ids == index)[:, ::-1].astype(np.float64)


def pixels_per_metre(observed: Observed, name: str, view: View) -> float:
    """Return the length (px) of a metre at the centre of a body, in the direction in which it is longest."""
    camera_name, time = view
    poses = observed.poses(time)
    camera = world_camera(observed.scene, Shot(camera_name, poses))
    frame = observed.picture(*view)
    height, width = frame.ids.shape
    middle = observed.track(name)[observed.moment(time)]
    points, depth = project(camera, np.vstack([middle, middle + _STEP * np.eye(3)]), width, height)
    if (depth <= camera.near).any():
        return 0.0
    jacobian = (points[1:] - points[0]) / _STEP
    return float(np.linalg.norm(jacobian, 2)) * scale(frame)
