"""Bodies in frames at the centre of mass along the principal axes.

There, free flight is exact in every engine and an inertia has three numbers.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from wmspec.core.memoize import cached_on
from wmspec.sim.scene.model import Array, Body, Inertia, Pose
from wmspec.sim.scene.model.transform import apply, compose, identity, inverse

_ROUND_OFF = 1e-12  # m, or of a unit quaternion


def body_frame_in_com(body: Body) -> Pose:
    """Return the body frame in the centre-of-mass frame; the identity unless the body is dynamic."""
    return cached_on(body, _mount)


def com_frame(body: Body) -> Body:
    """Return the body expressed in its centre-of-mass frame."""
    return body if body.inertia is None else cached_on(body, _com_frame)


def _mount(body: Body) -> Pose:
    return _clean(inverse(_center(body)))


def _com_frame(body: Body) -> Body:
    assert body.inertia is not None
    inside = body_frame_in_com(body)
    geoms = tuple(replace(geom, pose=_clean(compose(inside, geom.pose))) for geom in body.geoms)
    own = identity()
    inertia = Inertia(body.inertia.mass, own.position, own.orientation, body.inertia.moments)
    return replace(body, pose=compose(body.pose, _center(body)), geoms=geoms, inertia=inertia)


def transform_points(pose: Pose, points: Array) -> Array:
    """Return points transformed by `pose`, unchanged to the bit if it is the identity."""
    return points if is_identity(pose) else apply(pose, points)


def is_identity(pose: Pose) -> bool:
    """Whether the pose is the identity."""
    return not pose.position.any() and not pose.orientation[1:].any()


def _center(body: Body) -> Pose:
    return Pose(body.inertia.center, body.inertia.axes) if body.inertia else identity()


def _clean(pose: Pose) -> Pose:
    """Return the pose without round-off: engines treat a shape differently unless its frame equals the body frame."""
    position = np.where(np.abs(pose.position) < _ROUND_OFF, 0.0, pose.position)
    turned = np.abs(pose.orientation[1:]).max() >= _ROUND_OFF
    return Pose(position, pose.orientation if turned else identity().orientation)
