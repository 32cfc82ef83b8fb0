"""The bodies and joints of a scene in Newton's model builder."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf
from typing import Any

import numpy as np

from wmspec.core.native_output import silence
from wmspec.sim.scene.joints.articulations import Link
from wmspec.sim.scene.model.transform import multiply, rotate
from wmspec.sim.scene.physics.episode import Vector
from wmspec.sim.scene.physics.rigid import Assembly, CollisionShape

with silence():
    import newton

HEAVY = 1e6  # kg and kg m²: immovable by other bodies
WORLD = -1


@dataclass(frozen=True)
class Built:
    """A builder, and Newton's numbers: body -> link, body -> joint to its parent, shape -> body."""

    builder: Any
    links: dict[int, int]
    joints: dict[int, int]
    shapes: dict[int, int]


def build(assembly: Assembly, contacts: Any, limits: Vector) -> Built:
    """Return a builder with the bodies, joints and shapes of an assembly, in its order.

    `contacts`: parameters by materials. `limits`: `solref` of joint limits.
    """
    builder = newton.ModelBuilder()
    newton.solvers.SolverMuJoCo.register_custom_attributes(builder)
    limbs = {limb.body: limb for tree in assembly.trees for limb in tree}
    links = {i: add_link(builder, i, body) for i, body in enumerate(assembly.bodies) if body.motion != "static"}
    joints: dict[int, int] = {}
    for body, link in links.items():
        if body not in limbs:
            joints[body] = builder.add_joint_free(link, label=f"{body}")
            builder.add_articulation([joints[body]])
    for tree in assembly.trees:
        for limb in tree:
            joints[limb.body] = add_joint(builder, limb, links, limits)
        builder.add_articulation([joints[limb.body] for limb in tree])
    pieces = [
        [(add_shape(builder, links.get(i, WORLD), piece, body.start), piece.material) for piece in body.pieces]
        for i, body in enumerate(assembly.bodies)
    ]
    add_pairs(builder, assembly, pieces, contacts)
    return Built(builder, links, joints, {shape: i for i, made in enumerate(pieces) for shape, _ in made})


def add_link(builder: Any, number: int, body: Any) -> int:
    """Add a body that can move; a kinematic one is a heavy body whose state is set before every step."""
    led = body.motion == "kinematic"
    link: int = builder.add_link(
        xform=transform(body.start),
        mass=HEAVY if led else body.mass,
        inertia=np.diag([HEAVY] * 3 if led else body.moments),
        com=(0.0, 0.0, 0.0),
        label=f"{number}",
        lock_inertia=True,
        custom_attributes={"mujoco:gravcomp": 1.0} if led else None,
    )
    return link


def add_joint(builder: Any, limb: Link, links: dict[int, int], limits: Vector) -> int:
    """Add the joint between a body and its parent."""
    parent, child = links.get(limb.parent, WORLD), links[limb.body]
    joint: int
    if limb.kind == "free":
        joint = builder.add_joint_free(child, label=f"{limb.body}")
        return joint
    frames = {"parent_xform": transform(limb.above), "child_xform": transform(limb.below), "label": f"{limb.body}"}
    if limb.kind == "fixed":
        joint = builder.add_joint_fixed(parent, child, **frames)
        return joint
    if limb.kind == "ball":
        joint = builder.add_joint_ball(parent, child, armature=0.0, **frames)
        return joint
    low, high = limb.limits or (-inf, inf)
    axis = newton.ModelBuilder.JointDofConfig(axis=(1.0, 0.0, 0.0), armature=limb.armature)
    if limb.limits:
        axis.limit_lower, axis.limit_upper = low, high
        # Without mode 1 (as given) Newton takes its own gains, in which limits are soft.
        frames["custom_attributes"] = {"mujoco:solreflimit": [limits], "mujoco:solreflimit_mode": [1]}
    if limb.drive:
        stiffness, damping, target, velocity, most = limb.drive
        axis.target_ke, axis.target_kd, axis.target_q, axis.target_qd = stiffness, damping, target, velocity
        axis.effort_limit = min(most, 1e10)
        axis.actuator_mode = newton.JointTargetMode.POSITION_VELOCITY
    make = builder.add_joint_revolute if limb.kind == "hinge" else builder.add_joint_prismatic
    joint = make(parent, child, axis=axis, **frames)
    builder.joint_q[builder.joint_q_start[joint]] = limb.start
    return joint


def add_shape(builder: Any, link: int, piece: CollisionShape, start: Any) -> int:
    """Add a shape to a link, or to the world at the place of a static body."""
    common = {
        "body": link,
        "xform": transform(piece.pose if link != WORLD else compose(np.array(start), np.array(piece.pose))),
        "cfg": newton.ModelBuilder.ShapeConfig(density=0.0, collision_group=0),  # collides in listed pairs only
    }
    size = piece.size
    shape: int
    match piece.kind:
        case "box":
            shape = builder.add_shape_box(hx=size[0], hy=size[1], hz=size[2], **common)
        case "sphere":
            shape = builder.add_shape_sphere(radius=size[0], **common)
        case "cylinder":
            shape = builder.add_shape_cylinder(radius=size[0], half_height=size[1] / 2, **common)
        case "capsule":
            shape = builder.add_shape_capsule(radius=size[0], half_height=size[1] / 2, **common)
        case _:
            shape = builder.add_shape_convex_hull(mesh=hull(np.reshape(size, (-1, 3))), **common)
    return shape


def hull(points: Any) -> Any:
    """Return the convex hull of points (n, 3), m."""
    corners = np.asarray(points, np.float32)
    faces = np.arange(len(corners) // 3 * 3, dtype=np.int32)
    return newton.Mesh(corners, faces, compute_inertia=False, maxhullvert=len(corners)).compute_convex_hull()


def add_pairs(builder: Any, assembly: Assembly, pieces: Any, contacts: Any) -> None:
    """Add the pairs of shapes that can collide."""
    never, bodies = set(assembly.non_colliding_pairs), assembly.bodies
    for i, first in enumerate(pieces):
        for j in range(i + 1, len(pieces)):
            motions = bodies[i].motion, bodies[j].motion
            if (i, j) in never or "dynamic" not in motions:
                continue
            for a, p in first:
                for b, q in pieces[j]:
                    columns = contacts[p, q, "kinematic" in motions]
                    row = {f"mujoco:pair_{name}": value for name, value in columns.items()}
                    builder.add_custom_values(**{"mujoco:pair_geom1": a, "mujoco:pair_geom2": b, **row})


def compose(outer: Any, inner: Any) -> Any:
    """Return the pose (7,) of a pose `inner` in the frame `outer`."""
    return np.concatenate([outer[:3] + rotate(outer[3:], inner[:3]), multiply(outer[3:], inner[3:])])


def transform(pose: Any) -> Any:
    """Return Newton's transform of position and quaternion (w, x, y, z); Newton's quaternion is (x, y, z, w)."""
    x, y, z, w, i, j, k = map(float, pose)
    return (x, y, z), (i, j, k, w)
