"""Joint coordinates: the angle of a hinge, the extension of a slider."""

from __future__ import annotations

import numpy as np

from wmspec.core.diagnostics import WmsError
from wmspec.runtime.questions.observed import Observed
from wmspec.sim.scene.joints.articulations import joint_coordinate
from wmspec.sim.scene.model import Joint, JointKind, Pose
from wmspec.sim.scene.model.transform import compose, identity, inverse


def angle(observed: Observed, name: str, at: float | None = None) -> float:
    """Return the angle (rad) of a hinge at a time (s), full turns included; at the end by default."""
    joint = _joint(observed, name, "hinge")
    path = _path(observed, joint)
    turned = np.unwrap(2 * np.arctan2(path.orientation[:, 1], path.orientation[:, 0]))
    start = joint_coordinate(joint, Pose(path.position[0], path.orientation[0]))
    return float(start + turned[observed.moment(at)] - turned[0])


def extension(observed: Observed, name: str, at: float | None = None) -> float:
    """Return the extension (m) of a slider at a time (s); at the end by default."""
    return float(_path(observed, _joint(observed, name, "slider")).position[observed.moment(at), 0])


def _joint(observed: Observed, name: str, kind: JointKind) -> Joint:
    joint = next((joint for joint in observed.scene.joints if joint.name == name), None)
    if joint is None:
        raise WmsError(f"the joint `{name}` is absent, so it cannot be measured")
    if joint.kind != kind:
        raise WmsError(f"`{name}` is a {joint.kind} joint, and this is measured of a {kind}")
    return joint


def _path(observed: Observed, joint: Joint) -> Pose:
    """Return the second joint frame relative to the first at all times: (T, 3) and (T, 4)."""
    outer = compose(_track(observed, joint.first), joint.first_frame)
    return compose(inverse(outer), compose(_track(observed, joint.second), joint.second_frame))


def _track(observed: Observed, name: str | None) -> Pose:
    """Return the frames of a body at all times, (T, 3) and (T, 4); the identity for the world."""
    if name is None:
        return identity()
    i = observed.index(name)
    return Pose(observed.trace.position[:, i], observed.trace.orientation[:, i])
