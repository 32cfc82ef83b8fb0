"""How stiff a drive is for what it moves: an engine that computes it step by step overshoots if it is too stiff."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from wmspec.sim.scene.joints.articulations import Link, Tree, trees
from wmspec.sim.scene.joints.com_frame import com_frame
from wmspec.sim.scene.model import Array, Drive, Joint, Scene
from wmspec.sim.scene.model.numbers import placed
from wmspec.sim.scene.model.transform import compose, cross, rotate, rotation
from wmspec.sim.scene.regime_thresholds import FINEST

STIFFEST = 0.5  # of a vibration, in radians a step, squared; of a decay, the part in a step


def too_stiff(scene: Scene, rate: int) -> Iterator[Joint]:
    """The joints whose drives would vibrate faster than `rate` steps per second can follow."""
    return (joint for joint, drive, lightness in _driven(scene) if drive.stiffness * lightness > STIFFEST * rate**2)


def too_damped(scene: Scene, rate: int) -> Iterator[Joint]:
    """The joints whose drives would brake in less than `rate` steps per second can follow."""
    return (joint for joint, drive, lightness in _driven(scene) if drive.damping * lightness > STIFFEST * rate)


def enough(scene: Scene, rate: int, *, damped: bool = True) -> int:
    """The least of 1, 2, 4 .. `FINEST` times `rate` steps a second that the drives need; unless they can be `damped`
    however much, their damping counts too.
    """
    for finer in (1, 2, 4, 8):
        if not any(too_stiff(scene, finer * rate)) and not (damped and any(too_damped(scene, finer * rate))):
            return finer * rate
    return FINEST * rate


def weighed(scene: Scene) -> Scene:
    """The scene whose drives by acceleration are forces, for the mass or moment that each moves at the start."""
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
    """The joints with drives, and the acceleration that a force gives to them."""
    for tree in trees(scene) if any(joint.drive for joint in scene.joints) else ():
        lightness = mobility(scene, tree)
        for link in tree:
            if link.joint >= 0 and (drive := scene.joints[link.joint].drive):
                yield scene.joints[link.joint], drive, lightness[link.joint]


def mobility(scene: Scene, tree: Tree) -> dict[int, float]:
    """For each joint of one coordinate, the acceleration per force at the start, 1/kg or 1/(kg m²)."""
    bodies = [com_frame(scene.bodies[link.body]) for link in tree]
    columns = [column for link in tree for column in motions(scene, tree, link)]
    mass = np.zeros((len(columns), len(columns)))
    for i, body in enumerate(bodies):
        assert body.inertia is not None
        turn = rotation(body.pose.orientation)
        inertia = turn @ np.diag(body.inertia.moments) @ turn.T
        speeds = np.array([column[i] for column in columns])
        mass += body.inertia.mass * speeds[:, :3] @ speeds[:, :3].T + speeds[:, 3:] @ inertia @ speeds[:, 3:].T
    lightness = np.diag(np.linalg.inv(mass)) if columns else np.zeros(0)
    numbers = [link.joint for link in tree for _ in motions(scene, tree, link)]
    return dict(zip(numbers, lightness.tolist(), strict=True))


def motions(scene: Scene, tree: Tree, link: Link) -> list[Array]:
    """For each way that a joint moves, none of a fixed one: the linear and angular velocities (N, 6) of the bodies."""
    bodies = [com_frame(scene.bodies[one.body]) for one in tree]
    at = next(body for body, one in zip(bodies, tree, strict=True) if one is link)
    joint = compose(at.pose, placed(link.below))
    axes = [rotate(joint.orientation, axis) for axis in np.eye(3)]
    slides, turns = {"free": (3, 3), "ball": (0, 3), "hinge": (0, 1), "slider": (1, 0), "fixed": (0, 0)}[link.kind]
    carried = _below(tree, link)
    columns = []
    for axis, slide in [(a, True) for a in axes[:slides]] + [(a, False) for a in axes[:turns]]:
        column = np.zeros((len(tree), 6))
        for i, body in enumerate(bodies):
            if tree[i].body in carried:
                arm = body.pose.position - joint.position
                column[i] = [*axis, 0, 0, 0] if slide else [*cross(axis, arm), *axis]
        columns.append(column)
    return columns


def _below(tree: Tree, link: Link) -> set[int]:
    hanging = {link.body}
    for other in tree:
        if other.parent in hanging:
            hanging.add(other.body)
    return hanging
