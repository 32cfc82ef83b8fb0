"""How far joints have moved: the angle of a hinge, the extension of a slider."""

from __future__ import annotations

import numpy as np

from wmspec.core.diagnostics import WmsError
from wmspec.runtime.questions.observed import Observed
from wmspec.sim.scene.joints.articulations import coordinate
from wmspec.sim.scene.model import Joint, JointKind, Pose
from wmspec.sim.scene.model.transform import compose, identity, inverse


def angle(observed: Observed, name: str, at: float | None = None) -> float:
    """How far (rad) a hinge has turned from 0 by a time (s), whole turns included; by the end, if there is none."""
    joint = _joint(observed, name, "hinge")
    path = _path(observed, joint)
    turned = np.unwrap(2 * np.arctan2(path.orientation[:, 1], path.orientation[:, 0]))
    start = coordinate(joint, Pose(path.position[0], path.orientation[0]))
    return float(start + turned[observed.moment(at)] - turned[0])


def extension(observed: Observed, name: str, at: float | None = None) -> float:
    """How far (m) a slider has slid from 0 by a time (s); by the end, if there is none."""
    return float(_path(observed, _joint(observed, name, "slider")).position[observed.moment(at), 0])


def _joint(observed: Observed, name: str, kind: JointKind) -> Joint:
    joint = next((joint for joint in observed.scene.joints if joint.name == name), None)
    if joint is None:
        raise WmsError(f"the joint `{name}` is not there, so nothing can be measured on it")
    if joint.kind != kind:
        raise WmsError(f"`{name}` is a {joint.kind} joint, and this is measured of a {kind}")
    return joint


def _path(observed: Observed, joint: Joint) -> Pose:
    """Where the joint's second frame is at all times, seen from its first: (T, 3) and (T, 4)."""
    outer = compose(_track(observed, joint.first), joint.first_frame)
    return compose(inverse(outer), compose(_track(observed, joint.second), joint.second_frame))


def _track(observed: Observed, name: str | None) -> Pose:
    """The frames of a body at all times, (T, 3) and (T, 4); of the world, its own."""
    if name is None:
        return identity()
    i = observed.index(name)
    return Pose(observed.trace.position[:, i], observed.trace.orientation[:, i])
