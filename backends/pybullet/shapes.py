"""Collision shapes in PyBullet."""

from __future__ import annotations

from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from wmspec.core.native_output import silence
from wmspec.sim.scene.model.transform import conjugate, multiply, rotate
from wmspec.sim.scene.physics.episode import Vector
from wmspec.sim.scene.physics.rigid import CollisionShape

with silence():
    import pybullet

IDENTITY_POSE = (0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0)
KINDS = {
    "box": "GEOM_BOX",
    "sphere": "GEOM_SPHERE",
    "cylinder": "GEOM_CYLINDER",
    "capsule": "GEOM_CAPSULE",
    "hull": "GEOM_MESH",
}


def shape(pieces: tuple[CollisionShape, ...], frame: Vector, client: int) -> int:
    """Return the collision shape of shapes relative to a `frame` of their body; -1 for none."""
    if not pieces:
        return -1
    poses = [relative_pose(frame, piece.pose) for piece in pieces]
    one: int
    if len(pieces) == 1:
        one = pybullet.createCollisionShape(physicsClientId=client, **single(pieces[0], poses[0]))
        return one
    with TemporaryDirectory() as folder:
        one = pybullet.createCollisionShapeArray(physicsClientId=client, **several(pieces, poses, folder))
    return one


def relative_pose(frame: Vector, pose: Vector) -> Vector:
    """Return a pose in a frame: position and quaternion (w, x, y, z)."""
    if frame == IDENTITY_POSE:
        return pose
    back = conjugate(np.array(frame[3:]))
    place = rotate(back, np.array(pose[:3]) - np.array(frame[:3]))
    return (*place.tolist(), *multiply(back, np.array(pose[3:])).tolist())


def xyzw(turn: Any) -> Vector:
    """Return a quaternion (w, x, y, z) in PyBullet's order."""
    return (*turn[1:], turn[0])


def single(piece: CollisionShape, pose: Vector) -> dict[str, Any]:
    """Return arguments of `createCollisionShape`."""
    words: dict[str, Any] = {"shapeType": getattr(pybullet, KINDS[piece.kind])}
    match piece.kind:
        case "box":
            words |= {"halfExtents": piece.size}
        case "sphere":
            words |= {"radius": piece.size[0]}
        case "hull":
            words |= {"vertices": np.reshape(piece.size, (-1, 3)).tolist()}
        case _:
            words |= {"radius": piece.size[0], "height": piece.size[1]}
    if pose == IDENTITY_POSE:  # any offset makes it a compound shape
        return words
    return words | {"collisionFramePosition": pose[:3], "collisionFrameOrientation": xyzw(pose[3:])}


def several(pieces: tuple[CollisionShape, ...], poses: list[Vector], folder: str) -> dict[str, Any]:
    """Return arguments of `createCollisionShapeArray`, which accepts hulls from files only.

    It silently drops shapes after the sixteenth, so all hulls, which share a pose, form one shape.
    """
    hulls, file = [piece for piece in pieces if piece.kind == "hull"], Path(folder, "hulls.obj")
    if hulls:
        file.write_text(objects(hulls))
    rows = [(piece, poses[i]) for i, piece in enumerate(pieces) if piece.kind != "hull" or piece is hulls[0]]
    return {
        "shapeTypes": [getattr(pybullet, KINDS[piece.kind]) for piece, _ in rows],
        "halfExtents": [piece.size if piece.kind == "box" else (0.0, 0.0, 0.0) for piece, _ in rows],
        "radii": [0.0 if piece.kind in ("box", "hull") else piece.size[0] for piece, _ in rows],
        "lengths": [piece.size[1] if piece.kind in ("cylinder", "capsule") else 0.0 for piece, _ in rows],
        "fileNames": [str(file) if piece.kind == "hull" else "" for piece, _ in rows],
        "meshScales": [(1.0, 1.0, 1.0)] * len(rows),
        "collisionFramePositions": [pose[:3] for _, pose in rows],
        "collisionFrameOrientations": [xyzw(pose[3:]) for _, pose in rows],
    }


def objects(hulls: list[CollisionShape]) -> str:
    """Return hulls as Wavefront objects; PyBullet uses the hull of each object, so any faces are valid."""
    lines, first = [], 1
    for number, hull in enumerate(hulls):
        points = np.reshape(hull.size, (-1, 3)).tolist()
        corners = [f"v {x!r} {y!r} {z!r}" for x, y, z in points]
        faces = [f"f {first} {first + i} {first + i + 1}" for i in range(1, len(points) - 1)]
        lines += [f"o {number}", *corners, *faces]
        first += len(points)
    return "\n".join(lines) + "\n"
