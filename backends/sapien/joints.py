"""Joints in SAPIEN. PhysX articulations have no ball joints: trees are split there and held by constraints."""

from __future__ import annotations

from math import inf
from typing import Any

import numpy as np

from wmspec.core.native_output import silence
from wmspec.sim.scene.joints.articulations import Link, MimicConstraint, ancestors

with silence():
    import sapien

JOINTS = {"fixed": "fixed", "hinge": "revolute", "slider": "prismatic"}
MIMIC_FREQUENCY = 0.3  # rad per step: oscillation of a mimic joint about its leader
MIMIC_DAMPING = 0.5  # its damping: a quarter of critical
MAX_JOINT_SPEED = 1e4  # rad/s or m/s; PhysX's default is 100


def split_at_ball_joints(tree: tuple[Link, ...]) -> list[tuple[Link, ...]]:
    """Return a tree split at its ball joints; parts that hold others first."""
    parts: list[list[Link]] = []
    part_of: dict[int, list[Link]] = {}
    for limb in tree:
        if limb.kind == "ball" or limb.parent not in part_of:
            parts.append([])
        part = parts[-1] if limb.kind == "ball" or limb.parent not in part_of else part_of[limb.parent]
        part.append(limb)
        part_of[limb.body] = part
        if limb.parent < 0 and limb.kind not in ("free", "ball"):
            part_of[limb.parent] = part  # with the other links at the world of a merged tree
    return [tuple(part) for part in parts]


def connect(joint: Any, limb: Link, above: Any, *, geared: bool) -> None:
    """Set up the joint of an articulation; `above` is its frame in the parent link.

    PhysX hinges wrap to zero after two turns; those that are `geared` to others must not.
    """
    joint.set_type("revolute_unwrapped" if geared and limb.kind == "hinge" else JOINTS[limb.kind])
    joint.set_pose_in_parent(above)
    joint.set_pose_in_child(frame(limb.below))
    if limb.kind == "fixed":
        return
    low, high = limb.limits or (-inf, inf)
    joint.set_limits(np.array([[low, high]], np.float32))
    joint.set_friction(0.0)
    joint.set_armature(np.array([limb.armature], np.float32))
    joint.set_max_velocity(MAX_JOINT_SPEED)
    stiffness, damping, target, velocity, most = limb.drive or (0.0, 0.0, 0.0, 0.0, inf)
    joint.set_drive_properties(stiffness, damping, min(most, float(np.finfo(np.float32).max)), "force")
    joint.set_drive_target(target)
    joint.set_drive_velocity_target(velocity)


def couple(gear: MimicConstraint, branch: tuple[Link, ...], links: dict[int, Any], step: float) -> None:
    """Add a mimic constraint: a tendon as stiff as the step allows, whose force on each joint is its coefficient."""
    above = {limb.body: limb.parent for limb in branch}
    one, other = ancestors(gear.leader, above), ancestors(gear.body, above)
    root = next(body for body in one[1:] if body in other[1:])
    passed = {*one[: one.index(root)], *other[: other.index(root)]}
    chain = [root, *(limb.body for limb in branch if limb.body in passed)]
    pulls = [{gear.leader: -gear.ratio, gear.body: 1.0}.get(body, 0.0) for body in chain]
    stiffness = (MIMIC_FREQUENCY / step) ** 2 / gear.lightness
    parts = [links[body] for body in chain]
    damping = MIMIC_DAMPING * (MIMIC_FREQUENCY / step) / gear.lightness
    parts[0].articulation.create_fixed_tendon(parts, pulls, pulls, gear.offset, 0.0, stiffness, damping)


def ball(part: Any, parent: Any, inner: Any, outer: Any) -> Any:
    """Hold a body to its parent, or the world, at the origins of two frames, as a constraint."""
    joint = sapien.physx.PhysxDriveComponent(part)
    if parent is not None:
        joint.set_parent(parent)
    joint.set_pose_in_parent(outer)
    joint.set_pose_in_child(inner)
    for lock in (joint.set_limit_x, joint.set_limit_y, joint.set_limit_z):
        lock(0.0, 0.0)
    part.entity.add_component(joint)
    return joint


def collision_words(apart: tuple[tuple[int, int], ...], count: int) -> list[tuple[int, int]]:
    """Return the last two collision-group words of each body.

    Bodies that share a bit of the first word and the second word do not collide. Connected bodies share a number, and
    each clique a bit.
    """
    pairs = set(apart)
    group = list(range(count))
    for a, b in apart:
        low, high = sorted((group[a], group[b]))
        group = [low if g == high else g for g in group]
    words, used = [0] * count, dict.fromkeys(group, 0)
    while pairs:
        clique = list(min(pairs))
        for c in range(count):
            if c not in clique and all((min(c, d), max(c, d)) in apart for d in clique):
                clique.append(c)
        bit = used[group[clique[0]]]
        used[group[clique[0]]] += 1
        for body in clique:
            words[body] |= 1 << bit
        pairs -= {(a, b) for a in clique for b in clique}
    return list(zip(words, group, strict=True))


def frame(numbers: Any) -> Any:
    """Return SAPIEN's pose of position and quaternion (w, x, y, z)."""
    return sapien.Pose(np.array(numbers[:3], float), np.array(numbers[3:], float))
