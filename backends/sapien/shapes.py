"""Collision shapes in SAPIEN, and the lanes on which they collide."""

from __future__ import annotations

from math import sqrt
from typing import Any

import numpy as np

from wmspec.core.native_output import silence
from wmspec.sim.scene.model.transform import multiply
from wmspec.sim.scene.physics.episode import Vector
from wmspec.sim.scene.physics.rigid import CollisionShape, Rigid

from .joints import frame

with silence():
    import sapien

CONTACT_OFFSET = 1e-5  # m: a larger offset makes friction wrong by up to 100 %, depending on phase
ALONG_X = (sqrt(0.5), 0.0, -sqrt(0.5), 0.0)  # PhysX capsules and cylinders are along x
BITS = 32

Lanes = dict[tuple[Vector, Vector], int]


def lanes(bodies: tuple[Rigid, ...]) -> Lanes:
    """Return a number for every pair of materials that can touch, in order of the bodies."""
    numbers: Lanes = {}
    for i, a in enumerate(bodies):
        for b in bodies[i + 1 :]:
            if "dynamic" in (a.motion, b.motion):
                for pair in [(p.material, q.material) for p in a.pieces for q in b.pieces]:
                    numbers.setdefault(min(pair, pair[::-1]), len(numbers))
    return numbers


def geometric_mean(a: Vector, b: Vector) -> list[float]:
    """Return the geometric mean of two materials."""
    return [sqrt(x * y) for x, y in zip(a, b, strict=True)]


def groups(material: Vector, pair: tuple[Vector, Vector], bit: int) -> list[int]:
    """Return the collision groups on a lane: shapes collide if the first word of one and the second of the other share
    a bit.
    """
    return [(1 << bit) * (material == pair[0]), (1 << bit) * (material == pair[1])]


def shape(piece: CollisionShape, material: list[float], groups: list[int]) -> Any:
    """Return a copy of a shape for one lane."""
    physx, place = sapien.physx, piece.pose
    stuff = physx.PhysxMaterial(*material)
    match piece.kind:
        case "box":
            made = physx.PhysxCollisionShapeBox(np.array(piece.size, np.float32), stuff)
        case "sphere":
            made = physx.PhysxCollisionShapeSphere(piece.size[0], stuff)
        case "hull":
            points = np.reshape(piece.size, (-1, 3)).astype(np.float32)
            made = physx.PhysxCollisionShapeConvexMesh(points, np.ones(3, np.float32), stuff)
        case _:
            kind = {"cylinder": physx.PhysxCollisionShapeCylinder, "capsule": physx.PhysxCollisionShapeCapsule}
            made = kind[piece.kind](piece.size[0], piece.size[1] / 2, stuff)
            place = (*piece.pose[:3], *multiply(np.array(piece.pose[3:]), np.array(ALONG_X)))
    made.set_local_pose(frame(place))
    made.set_collision_groups(groups)
    made.set_contact_offset(CONTACT_OFFSET)
    made.set_rest_offset(0.0)
    return made
