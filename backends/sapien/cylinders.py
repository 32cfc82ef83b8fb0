"""Cylinders that roll: PhysX models them as prisms, which brake; they roll on a capsule inside.

A capsule of the same radius reaches the side and, unless the cylinder is a disc, stays within its ends. The slightly
thinner prism supports it when standing. If height equals diameter, the capsule is a ball that touches the ground and
turns a sliding cylinder: one that stands has none.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from wmspec.sim.scene.model import Array
from wmspec.sim.scene.model.transform import rotate
from wmspec.sim.scene.physics.rigid import Assembly, CollisionShape, Rigid
from wmspec.sim.scene.regime_thresholds import CAPSULE_CLEARANCE, STEEP_COSINE, is_disc

SIDE_CLEARANCE = 2e-3  # relative to the radius: gap between prism and side
MIN_STRAIGHT = 1e-6  # m: length of the straight part


def add_rolling_capsules(assembly: Assembly) -> Assembly:
    """Return the bodies with capsules in the cylinders of moving ones."""
    size = np.linalg.norm(assembly.gravity)
    down = np.array(assembly.gravity) / size if size else np.zeros(3)
    return replace(assembly, bodies=tuple(_body(body, down) for body in assembly.bodies))


def _body(body: Rigid, down: Array) -> Rigid:
    if body.motion == "static":
        return body
    if body.motion == "kinematic":
        down = np.zeros(3)
    below = rotate(np.array([1.0, -1.0, -1.0, -1.0]) * body.start[3:], down)
    return replace(body, pieces=tuple(part for piece in body.pieces for part in _parts(piece, below)))


def _parts(piece: CollisionShape, down: Array) -> tuple[CollisionShape, ...]:
    stands = bool(abs(rotate(np.array(piece.pose[3:]), np.array([0.0, 0.0, 1.0])) @ down) >= STEEP_COSINE)
    if piece.kind != "cylinder" or is_disc(*piece.size, stands=stands):
        return (piece,)
    radius, height = piece.size
    prism = replace(piece, size=(radius * (1 - SIDE_CLEARANCE), height))
    straight = max(height - 2 * (radius + CAPSULE_CLEARANCE), MIN_STRAIGHT)
    return prism, replace(piece, kind="capsule", size=(radius, straight))
