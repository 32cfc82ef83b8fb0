"""All joint coordinates of a scene: Jacobians and mass matrix."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from wmspec.sim.scene.joints.articulations import MimicConstraint, Tree, trees
from wmspec.sim.scene.joints.com_frame import com_frame
from wmspec.sim.scene.joints.drives import motions
from wmspec.sim.scene.model import Array, Scene
from wmspec.sim.scene.model.transform import rotation


@dataclass(frozen=True)
class Coordinates:
    """The n joint coordinates of N bodies.

    `bodies` (N,): numbers of the bodies in trees. `ways` (n, 6 N): Jacobian, the body velocities (world axes) per unit
    rate of each coordinate. `holders` (n,): the body below each joint. `masses` (6 N, 6 N): mass matrix.
    """

    bodies: tuple[int, ...]
    ways: Array
    holders: tuple[int, ...]
    masses: Array

    def along(self, body: int) -> Array:
        """Return the unit vector (n,) of the coordinate of the joint above a body."""
        return np.array([float(holder == body) for holder in self.holders])


def coordinates(scene: Scene) -> Coordinates:
    """Return the coordinates of all trees at the start."""
    grown = trees(scene)
    order = tuple(link.body for tree in grown for link in tree)
    each = [(body, way) for tree in grown for body, way in _ways(scene, tree, order)]
    ways = np.array([way for _, way in each]).reshape(-1, 6 * len(order))
    return Coordinates(order, ways, tuple(body for body, _ in each), _masses(scene, order))


def mimic_constraints(scene: Scene) -> tuple[MimicConstraint, ...]:
    """Return the constraints of mimic joints."""
    if not any(joint.mimic for joint in scene.joints):
        return ()
    all_ = coordinates(scene)
    links = [link for tree in trees(scene) for link in tree]
    rotors = {link.body: link.armature for link in links}
    heavy = np.linalg.inv(all_.ways @ all_.masses @ all_.ways.T + np.diag([rotors[body] for body in all_.holders]))
    holds, start = {link.joint: link.body for link in links}, {link.body: link.start for link in links}
    number = {joint.name: j for j, joint in enumerate(scene.joints)}
    made = []
    for j, joint in enumerate(scene.joints):
        if joint.mimic:
            body, leader = holds[j], holds[number[joint.mimic.leader]]
            pull = all_.along(body) - joint.mimic.ratio * all_.along(leader)
            light = float(pull @ heavy @ pull)
            offset = start[body] - joint.mimic.ratio * start[leader]  # satisfied at the start, up to full turns
            made.append(MimicConstraint(j, body, leader, float(joint.mimic.ratio), float(offset), light))
    return tuple(made)


def _ways(scene: Scene, tree: Tree, order: tuple[int, ...]) -> Iterator[tuple[int, Array]]:
    at = [order.index(link.body) for link in tree]
    for link in tree:
        for column in motions(scene, tree, link):
            whole = np.zeros((len(order), 6))
            whole[at] = column
            yield link.body, whole.ravel()


def _masses(scene: Scene, order: tuple[int, ...]) -> Array:
    whole = np.zeros((6 * len(order), 6 * len(order)))
    for i, number in enumerate(order):
        body = com_frame(scene.bodies[number])
        assert body.inertia is not None
        turn = rotation(body.pose.orientation)
        at = slice(6 * i, 6 * i + 3), slice(6 * i + 3, 6 * i + 6)
        whole[at[0], at[0]] = body.inertia.mass * np.eye(3)
        whole[at[1], at[1]] = turn @ np.diag(body.inertia.moments) @ turn.T
    return whole
