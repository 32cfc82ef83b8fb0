"""Stiffness of drives relative to the step rate: explicit integration overshoots if a drive is too stiff."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from wmspec.sim.scene.joints.articulations import Link, Tree, subtree, trees
from wmspec.sim.scene.joints.com_frame import com_frame
from wmspec.sim.scene.model import Array, Drive, Joint, Scene
from wmspec.sim.scene.model.numbers import pose_of
from wmspec.sim.scene.model.transform import compose, cross, rotate, rotation
from wmspec.sim.scene.regime_thresholds import MAX_STEP_MULTIPLIER, MAX_STEP_RESPONSE


def too_stiff(scene: Scene, rate: int) -> Iterator[Joint]:
    """Yield joints whose drives oscillate too fast for `rate` steps per second."""
    return (
        joint for joint, drive, lightness in _driven(scene) if drive.stiffness * lightness > MAX_STEP_RESPONSE * rate**2
    )


def too_damped(scene: Scene, rate: int) -> Iterator[Joint]:
    """Yield joints whose drives decay too fast for `rate` steps per second."""
    return (joint for joint, drive, lightness in _driven(scene) if drive.damping * lightness > MAX_STEP_RESPONSE * rate)


def required_step_rate(scene: Scene, rate: int, *, damped: bool = True) -> int:
    """Return the lowest of 1, 2, 4 .. `MAX_STEP_MULTIPLIER` times `rate` that all drives need.

    With `damped`, damping counts like stiffness.
    """
    for finer in (1, 2, 4, 8):
        if not any(too_stiff(scene, finer * rate)) and not (damped and any(too_damped(scene, finer * rate))):
            return finer * rate
    return MAX_STEP_MULTIPLIER * rate


def with_force_drives(scene: Scene) -> Scene:
    """Return the scene with acceleration drives converted to force drives, using initial effective masses."""
    if not any(joint.drive and joint.drive.weightless for joint in scene.joints):
        return scene
    moved = {number: 1 / light for tree in trees(scene) for number, light in mobility(scene, tree).items()}
    return replace(scene, joints=tuple(_weighed(joint, moved.get(i, 1.0)) for i, joint in enumerate(scene.joints)))


def _weighed(joint: Joint, mass: float) -> Joint:
    if joint.drive is None or not joint.drive.weightless:
        return joint
    stiffness, damping = joint.drive.stiffness * mass, joint.drive.damping * mass
    return replace(joint, drive=replace(joint.drive, stiffness=stiffness, damping=damping, weightless=False))


def _driven(scene: Scene) -> Iterator[tuple[Joint, Drive, float]]:
    """Yield joints with drives, and their acceleration per unit of force."""
    for tree in trees(scene) if any(joint.drive for joint in scene.joints) else ():
        lightness = mobility(scene, tree)
        for link in tree:
            if link.joint >= 0 and (drive := scene.joints[link.joint].drive):
                yield scene.joints[link.joint], drive, lightness[link.joint]


def mobility(scene: Scene, tree: Tree) -> dict[int, float]:
    """Return the initial acceleration per unit of force for each joint with one coordinate, 1/kg or 1/(kg m²)."""
    bodies = [com_frame(scene.bodies[link.body]) for link in tree]
    columns = [column for link in tree for column in motions(scene, tree, link)]
    mass = np.zeros((len(columns), len(columns)))
    for i, body in enumerate(bodies):
        assert body.inertia is not None
        turn = rotation(body.pose.orientation)
        inertia = turn @ np.diag(body.inertia.moments) @ turn.T
        speeds = np.array([column[i] for column in columns])
        mass += body.inertia.mass * speeds[:, :3] @ speeds[:, :3].T + speeds[:, 3:] @ inertia @ speeds[:, 3:].T
    numbers = [link.joint for link in tree for _ in motions(scene, tree, link)]
    mass += np.diag([scene.joints[number].armature if number >= 0 else 0.0 for number in numbers])
    lightness = np.diag(np.linalg.inv(mass)) if columns else np.zeros(0)
    return dict(zip(numbers, lightness.tolist(), strict=True))


def motions(scene: Scene, tree: Tree, link: Link) -> list[Array]:
    """Return the Jacobian columns of a joint: linear and angular body velocities (N, 6); none if fixed."""
    bodies = [com_frame(scene.bodies[one.body]) for one in tree]
    at = next(body for body, one in zip(bodies, tree, strict=True) if one is link)
    joint = compose(at.pose, pose_of(link.below))
    axes = [rotate(joint.orientation, axis) for axis in np.eye(3)]
    slides, turns = {"free": (3, 3), "ball": (0, 3), "hinge": (0, 1), "slider": (1, 0), "fixed": (0, 0)}[link.kind]
    carried = subtree(tree, link.body)
    columns = []
    for axis, slide in [(a, True) for a in axes[:slides]] + [(a, False) for a in axes[:turns]]:
        column = np.zeros((len(tree), 6))
        for i, body in enumerate(bodies):
            if tree[i].body in carried:
                arm = body.pose.position - joint.position
                column[i] = [*axis, 0, 0, 0] if slide else [*cross(axis, arm), *axis]
        columns.append(column)
    return columns
