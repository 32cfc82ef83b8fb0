"""The upright box around shapes: how far each reaches along the axes of the world."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from wmspec.core.memoize import cached_on
from wmspec.sim.scene.model import Array, Body, Geom, Pose
from wmspec.sim.scene.model.transform import compose, identity, rotate, rotation
from wmspec.sim.shapes import Shape

#: A middle nearer (m) than this to the frame is there.
_ROUNDING = 1e-12


def bounds(shape: Shape, pose: Pose) -> Array:
    """The lowest and highest coordinates (2, 3) m of a shape placed at `pose`."""
    return shape.bounds(rotation(pose.orientation)) + pose.position


def upright(geoms: Iterable[Geom], pose: Pose) -> Array:
    """The corners (2, 3) m of the upright box around pieces of a body that is placed at `pose`."""
    boxes = np.stack([bounds(g.shape, compose(pose, g.pose)) for g in geoms])
    return np.stack([boxes[:, 0].min(axis=0), boxes[:, 1].max(axis=0)])


def middle(body: Body, frames: Pose) -> Array:
    """Where the middle (..., 3) of a body's own box is, its frame being at `frames`, (..., 3) and (..., 4)."""
    return frames.position + rotate(frames.orientation, own_middle(body))


def own_middle(body: Body) -> Array:
    """Where the middle (3,) of a body's own box is in its frame."""
    return cached_on(body, _own_middle)


def _own_middle(body: Body) -> Array:
    own = upright(body.geoms, identity()).mean(axis=0) if body.geoms else np.zeros(3)
    return np.where(np.abs(own) < _ROUNDING, 0.0, own)
