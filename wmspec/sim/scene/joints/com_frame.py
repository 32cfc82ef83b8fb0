"""Bodies as engines like them: frame at the centre of mass, along the principal axes.

There free flight is exact in every engine and an inertia is three numbers.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from wmspec.core.memoize import cached_on
from wmspec.sim.scene.model import Array, Body, Inertia, Pose
from wmspec.sim.scene.model.transform import apply, compose, identity, inverse

_ROUND_OFF = 1e-12  # m, or of a unit quaternion


def mount(body: Body) -> Pose:
    """The body's own frame, seen from its centre-of-mass frame (the same one, unless it is dynamic)."""
    return cached_on(body, _mount)


def com_frame(body: Body) -> Body:
    """The same body, described in its centre-of-mass frame."""
    return body if body.inertia is None else cached_on(body, _com_frame)


def _mount(body: Body) -> Pose:
    return _clean(inverse(_center(body)))


def _com_frame(body: Body) -> Body:
    assert body.inertia is not None
    inside = mount(body)
    geoms = tuple(replace(geom, pose=_clean(compose(inside, geom.pose))) for geom in body.geoms)
    own = identity()
    inertia = Inertia(body.inertia.mass, own.position, own.orientation, body.inertia.moments)
    return replace(body, pose=compose(body.pose, _center(body)), geoms=geoms, inertia=inertia)


def placed(pose: Pose, points: Array) -> Array:
    """Points of a shape in the frame around it; exactly themselves if the shape is not moved."""
    return points if is_identity(pose) else apply(pose, points)


def is_identity(pose: Pose) -> bool:
    """Whether the pose changes nothing."""
    return not pose.position.any() and not pose.orientation[1:].any()


def _center(body: Body) -> Pose:
    return Pose(body.inertia.center, body.inertia.axes) if body.inertia else identity()


def _clean(pose: Pose) -> Pose:
    """Free of rounding: engines treat a shape differently unless its frame is exactly the body's."""
    position = np.where(np.abs(pose.position) < _ROUND_OFF, 0.0, pose.position)
    turned = np.abs(pose.orientation[1:]).max() >= _ROUND_OFF
    return Pose(position, pose.orientation if turned else identity().orientation)
