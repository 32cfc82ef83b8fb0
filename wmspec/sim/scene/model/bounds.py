"""Axis-aligned bounding boxes of shapes and bodies."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from wmspec.core.memoize import cached_on
from wmspec.sim.scene.model import Array, Body, Geom, Pose
from wmspec.sim.scene.model.transform import compose, identity, rotate, rotation
from wmspec.sim.shapes import Shape

#: m: a smaller distance of the centre from the frame is rounding.
_ROUNDING = 1e-12


def bounds(shape: Shape, pose: Pose) -> Array:
    """Return the lowest and highest coordinates (2, 3) m of a shape placed at `pose`."""
    return shape.bounds(rotation(pose.orientation)) + pose.position


def world_box(geoms: Iterable[Geom], pose: Pose) -> Array:
    """Return the corners (2, 3) m of the axis-aligned box around geoms of a body placed at `pose`.

    Without geoms it is the point of the frame: a body that is neither solid nor drawn, such as a carrier of a camera.
    """
    if not (geoms := tuple(geoms)):
        return np.stack([pose.position, pose.position])
    boxes = np.stack([bounds(g.shape, compose(pose, g.pose)) for g in geoms])
    return np.stack([boxes[:, 0].min(axis=0), boxes[:, 1].max(axis=0)])


def box_center(body: Body, frames: Pose) -> Array:
    """Return the centre (..., 3) of a body's own box for body frames `frames`, (..., 3) and (..., 4)."""
    return frames.position + rotate(frames.orientation, own_box_center(body))


def own_box_center(body: Body) -> Array:
    """Return the centre (3,) of a body's own box in its frame."""
    return cached_on(body, _own_middle)


def _own_middle(body: Body) -> Array:
    own = world_box(body.geoms, identity()).mean(axis=0) if body.geoms else np.zeros(3)
    return np.where(np.abs(own) < _ROUNDING, 0.0, own)
