"""The upright box around shapes: how far each reaches along the axes of the world."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from wmspec.scene.model import Array, Body, Box, Capsule, Cone, Cylinder, Geom, Mesh, Pose, Shape, Sphere
from wmspec.scene.transform import compose, identity, rotate, rotation

#: A middle nearer (m) than this to the frame is there.
_ROUNDING = 1e-12


def bounds(shape: Shape, pose: Pose) -> Array:
    """The lowest and highest coordinates (2, 3) m of a shape placed at `pose`."""
    turn = rotation(pose.orientation)
    if isinstance(shape, Mesh):
        points = np.asarray(shape.points, float) @ turn.T
        return np.stack([points.min(axis=0), points.max(axis=0)]) + pose.position
    reach = _reach(shape, turn)
    return np.stack([-_reach(shape, -turn), reach]) + pose.position


def _reach(shape: Shape, turn: Array) -> Array:
    """How far (3,) a shape that is no mesh, turned by a matrix, reaches in the directions +x, +y and +z."""
    along = turn[:, 2]
    across = np.sqrt(np.clip(1.0 - along**2, 0.0, None))
    match shape:
        case Box():
            return np.asarray(np.abs(turn) @ np.asarray(shape.half, float))
        case Sphere():
            return np.full(3, shape.radius)
        case Cylinder():
            return np.asarray(np.abs(along) * shape.height / 2 + across * shape.radius)
        case Capsule():
            return np.abs(along) * shape.height / 2 + shape.radius
        case Cone():
            return np.maximum(along * shape.height / 2, across * shape.radius - along * shape.height / 2)
        case Mesh():
            raise AssertionError(shape)


def upright(geoms: Iterable[Geom], pose: Pose) -> Array:
    """The corners (2, 3) m of the upright box around pieces of a body that is placed at `pose`."""
    boxes = np.stack([bounds(g.shape, compose(pose, g.pose)) for g in geoms])
    return np.stack([boxes[:, 0].min(axis=0), boxes[:, 1].max(axis=0)])


def middle(body: Body, frames: Pose) -> Array:
    """Where the middle (..., 3) of a body's own box is, its frame being at `frames`, (..., 3) and (..., 4)."""
    if not body.geoms:
        return frames.position
    own = upright(body.geoms, identity()).mean(axis=0)
    return frames.position + rotate(frames.orientation, np.where(np.abs(own) < _ROUNDING, 0.0, own))
