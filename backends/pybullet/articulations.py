"""Trees of jointed bodies as PyBullet multibodies, whose link frames are at the joints."""

from __future__ import annotations

from typing import Any

from wmspec.core.native_output import silence
from wmspec.sim.scene.joints.articulations import Link
from wmspec.sim.scene.physics.rigid import Rigid

from .shapes import IDENTITY_POSE, relative_pose, xyzw

with silence():
    import pybullet

JOINTS = {"fixed": "JOINT_FIXED", "hinge": "JOINT_REVOLUTE", "slider": "JOINT_PRISMATIC", "ball": "JOINT_SPHERICAL"}
SELF_COLLISION_FLAGS = ("URDF_USE_SELF_COLLISION", "URDF_USE_SELF_COLLISION_INCLUDE_PARENT")


def add_multibody(
    tree: tuple[Link, ...], bodies: tuple[Rigid, ...], shapes: list[int], client: int
) -> dict[int, tuple[int, int]]:
    """Add a tree with a shape per body; return body -> (multibody, link).

    The base of a tree at the world is massless, at its joint. Motors are off.
    """
    floats = tree[0].kind == "free"
    order = depth_first(tree)
    shapes = [shapes[tree.index(limb)] for limb in order]
    base, links = tree[0], order[1:] if floats else order
    place = bodies[base.body].start if floats else base.above
    number = {limb.body: i + 1 for i, limb in enumerate(links)} | ({base.body: 0} if floats else {-1: 0})
    frames = {limb.body: limb.below for limb in links}
    above = [frames.get(limb.parent, IDENTITY_POSE) if limb.parent >= 0 else base.above for limb in links]
    joints = [
        IDENTITY_POSE if limb is base else relative_pose(at, limb.above) for at, limb in zip(above, links, strict=True)
    ]
    middles = [relative_pose(limb.below, IDENTITY_POSE) for limb in links]
    handle: int = pybullet.createMultiBody(
        bodies[base.body].mass if floats else 0.0,
        shapes[0] if floats else -1,
        -1,
        place[:3],
        xyzw(place[3:]),
        linkMasses=[bodies[limb.body].mass for limb in links],
        linkCollisionShapeIndices=shapes[1:] if floats else shapes,
        linkVisualShapeIndices=[-1] * len(links),
        linkPositions=[joint[:3] for joint in joints],
        linkOrientations=[xyzw(joint[3:]) for joint in joints],
        linkInertialFramePositions=[middle[:3] for middle in middles],
        linkInertialFrameOrientations=[xyzw(middle[3:]) for middle in middles],
        linkParentIndices=[number[limb.parent] for limb in links],
        linkJointTypes=[getattr(pybullet, JOINTS[limb.kind]) for limb in links],
        linkJointAxis=[[1.0, 0.0, 0.0]] * len(links),
        flags=sum(getattr(pybullet, flag) for flag in SELF_COLLISION_FLAGS),
        physicsClientId=client,
    )
    for i, limb in enumerate(links):
        disable_motor(handle, i, limb.kind, client)
    return {limb.body: (handle, number[limb.body] - 1) for limb in tree}


def depth_first(tree: tuple[Link, ...]) -> tuple[Link, ...]:
    """Return the links of a tree in depth-first order, in which PyBullet numbers them."""
    order: list[Link] = []
    waiting = [limb for limb in reversed(tree) if limb.parent < 0]
    while waiting:
        order.append(waiting.pop())
        waiting += [limb for limb in reversed(tree) if limb.parent == order[-1].body]
    return tuple(order)


def disable_motor(handle: int, link: int, kind: str, client: int) -> None:
    """Disable the motor that PyBullet adds to every joint."""
    if kind == "ball":
        stop: dict[str, Any] = {
            "targetPosition": [0, 0, 0, 1],
            "positionGain": 0,
            "velocityGain": 0,
            "force": [0, 0, 0],
        }
        pybullet.setJointMotorControlMultiDof(handle, link, pybullet.POSITION_CONTROL, physicsClientId=client, **stop)
    elif kind != "fixed":
        pybullet.setJointMotorControl2(handle, link, pybullet.VELOCITY_CONTROL, force=0, physicsClientId=client)


def reset_tree(
    tree: tuple[Link, ...], made: dict[int, tuple[int, int]], bodies: tuple[Rigid, ...], client: int, *, moving: bool
) -> None:
    """Reset a tree to its start, with initial velocities if `moving`."""
    if tree[0].kind == "free":
        handle, place = made[tree[0].body][0], bodies[tree[0].body].start
        pybullet.resetBasePositionAndOrientation(handle, place[:3], xyzw(place[3:]), physicsClientId=client)
        speeds = (moving and bodies[tree[0].body].velocity) or (0.0,) * 6
        pybullet.resetBaseVelocity(handle, speeds[:3], speeds[3:], physicsClientId=client)
    for limb in tree:
        rate = (moving and limb.rate) or (0.0,) * 3
        if limb.kind == "ball":
            pybullet.resetJointStateMultiDof(*made[limb.body], [0, 0, 0, 1], rate, physicsClientId=client)
        elif limb.kind in ("hinge", "slider"):
            pybullet.resetJointState(*made[limb.body], limb.start, rate[0], physicsClientId=client)
