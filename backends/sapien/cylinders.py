"""Cylinders that roll: PhysX's are prisms, which brake as they roll; a capsule inside is what they roll on.

A capsule as thick as the cylinder reaches its side and, unless the cylinder is a disc, stays within its ends. The
prism, a little thinner then, is what it stands on. Where the cylinder is as long as thick the capsule is a ball, which
touches what it stands on, and turns it aside as it slides: one that stands has none.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from wmspec.sim.scene.model import Array
from wmspec.sim.scene.model.transform import rotate
from wmspec.sim.scene.physics.rigid import Assembly, Piece, Rigid
from wmspec.sim.scene.regime_thresholds import ROOM, STEEP, disc

THINNER = 2e-3  # of the radius: how far the prism stays within the side
SHORTEST = 1e-6  # m: of its straight part


def barrels(assembly: Assembly) -> Assembly:
    """The same bodies, with capsules in the cylinders of those that move."""
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


def _parts(piece: Piece, down: Array) -> tuple[Piece, ...]:
    stands = bool(abs(rotate(np.array(piece.pose[3:]), np.array([0.0, 0.0, 1.0])) @ down) >= STEEP)
    if piece.kind != "cylinder" or disc(*piece.size, stands=stands):
        return (piece,)
    radius, height = piece.size
    prism = replace(piece, size=(radius * (1 - THINNER), height))
    straight = max(height - 2 * (radius + ROOM), SHORTEST)
    return prism, replace(piece, kind="capsule", size=(radius, straight))
