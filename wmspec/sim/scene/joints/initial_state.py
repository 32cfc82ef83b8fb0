"""Initial poses of jointed bodies: bodies that violate a joint or its limits are moved to satisfy it.

A moved body carries its subtree along.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from math import atan2

import numpy as np

from wmspec.core.diagnostics import Diagnostic, StageError
from wmspec.core.places import PrimPlace
from wmspec.sim.scene.joints.articulations import Branch, joint_coordinate, relative_frame, spanning_trees, subtree
from wmspec.sim.scene.joints.mimics import mimic_error
from wmspec.sim.scene.model import Body, Joint, Pose, Scene
from wmspec.sim.scene.model.transform import compose, from_rotation_vector, identity, inverse, to_rotation_vector

REPORTED_SHIFT = 1e-5
"""m or rad: smaller shifts are not reported."""


def project_to_limits(scene: Scene) -> tuple[Scene, tuple[Diagnostic, ...]]:
    """Return the scene with joints and limits satisfied, and a warning for each body that was moved."""
    warnings: list[Diagnostic] = []
    for tree in spanning_trees(scene):
        for branch in tree:
            if branch.joint >= 0 and (moved := _shift_into_joint(scene.joints[branch.joint], scene.bodies, branch)):
                scene = _apply_shift(scene, tree, branch, moved, warnings)
    names = {joint.name: joint for joint in scene.joints}
    for tree in spanning_trees(scene):
        for branch in tree:
            if branch.joint >= 0 and (moved := _shift_to_mimic(scene, scene.joints[branch.joint], names, branch)):
                scene = _apply_shift(scene, tree, branch, moved, warnings)
    return scene, tuple(warnings)


_Move = tuple[Pose, float, float]
"""A world-frame displacement of a body, and its size (m, rad)."""


def _apply_shift(
    scene: Scene, tree: tuple[Branch, ...], branch: Branch, moved: _Move, warnings: list[Diagnostic]
) -> Scene:
    """Return the scene with a body and its subtree moved; append a warning if the shift exceeds `REPORTED_SHIFT`."""
    step, gap, turn = moved
    below = subtree(tree, branch.body)
    bodies = [
        replace(body, pose=compose(step, body.pose)) if i in below else body for i, body in enumerate(scene.bodies)
    ]
    reason = f"it starts {1e3 * gap:.3g} mm and {turn:.3g} rad outside its joint or limits"
    place = PrimPlace(scene.joints[branch.joint].path)
    if max(gap, turn) > REPORTED_SHIFT:
        warnings.append(Diagnostic(f"{reason}; {bodies[branch.body].path} is moved", place, severity="warning"))
    return replace(scene, bodies=tuple(bodies))


def _shift_to_mimic(scene: Scene, joint: Joint, names: dict[str, Joint], branch: Branch) -> _Move | None:
    """Return the displacement that satisfies a mimic joint, or None."""
    if joint.mimic is None or joint.mimic.leader not in names or abs(off := mimic_error(scene, joint, names)) < 1e-12:
        return None
    named = {body.name: body for body in scene.bodies}
    between = relative_frame(named, joint.first, joint.second, joint.first_frame, joint.second_frame)
    back = -off * np.array([1.0, 0.0, 0.0])
    still = identity()
    step = Pose(back, still.orientation) if joint.kind == "slider" else Pose(np.zeros(3), from_rotation_vector(back))
    return _shift_to(joint, named, branch, between, compose(between, step))


def _shift_into_joint(joint: Joint, bodies: Sequence[Body], branch: Branch) -> _Move | None:
    """Return the displacement that satisfies a joint and its limits, or None if they hold already."""
    named = {body.name: body for body in bodies}
    between = relative_frame(named, joint.first, joint.second, joint.first_frame, joint.second_frame)
    try:
        joint_coordinate(joint, between)
    except StageError:
        target = _nearest(joint, between)
    else:
        return None
    return _shift_to(joint, named, branch, between, target)


def _shift_to(joint: Joint, named: dict[str, Body], branch: Branch, between: Pose, target: Pose) -> _Move:
    """Return the displacement that brings the second joint frame from `between` to `target` in the first."""
    body = list(named.values())[branch.body]
    here = body.pose
    if body.name == joint.second:
        first = named[joint.first].pose if joint.first is not None else identity()
        there = compose(compose(compose(first, joint.first_frame), target), inverse(joint.second_frame))
    else:
        second = compose(named[joint.second].pose, joint.second_frame)
        there = compose(compose(second, inverse(target)), inverse(joint.first_frame))
    off = compose(inverse(between), target)
    size = float(np.linalg.norm(off.position)), float(np.linalg.norm(to_rotation_vector(off.orientation)))
    return compose(there, inverse(here)), *size


def _nearest(joint: Joint, between: Pose) -> Pose:
    """Return the allowed pose of the second joint frame that is nearest to `between`."""
    low, high = joint.limits if joint.limits and joint.kind != "ball" else (-np.inf, np.inf)
    x, still = np.array([1.0, 0.0, 0.0]), identity()
    match joint.kind:
        case "slider":
            return Pose(x * min(max(between.position[0], low), high), still.orientation)
        case "hinge":
            q = between.orientation
            angle = (2 * atan2(q[1], q[0]) + np.pi) % (2 * np.pi) - np.pi
            options = [angle + 2 * np.pi * k for k in (0, -1, 1)]
            best = min(options, key=lambda a: abs(a - min(max(a, low), high)))
            return Pose(still.position, from_rotation_vector(x * min(max(best, low), high)))
        case "ball":
            return Pose(still.position, between.orientation)
        case _:
            return still
