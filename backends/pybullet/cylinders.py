"""Cylinders that stand and slide correctly: two boxes inside them, with corners at the rims, support them.

Bullet finds one contact per step on a flat round end and keeps stale ones: a sliding cylinder brakes up to 8 % too much
and turns. Contacts of boxes are found all at once and are exact.
"""

from __future__ import annotations

from dataclasses import replace
from math import cos, pi, sin, sqrt

import numpy as np

from wmspec.sim.scene.model.transform import multiply
from wmspec.sim.scene.physics.rigid import Assembly, CollisionShape, Rigid

from .info import MAX_PIECES

END_OVERHANG = 1e-5  # m: the boxes protrude at the ends, so that the cylinder itself does not touch there
SIDE_CLEARANCE = 2e-3  # relative to the radius: gap between boxes and the rolling side
OCTAGON_TURN = pi / 4  # two squares rotated by this have the corners of an octagon


def add_support_boxes(assembly: Assembly) -> Assembly:
    """Return the bodies with support boxes in the cylinders of moving ones, within PyBullet's limit of pieces."""
    return replace(assembly, bodies=tuple(map(_body, assembly.bodies)))


def _body(body: Rigid) -> Rigid:
    kinds = [piece.kind for piece in body.pieces]
    many = len(kinds) - max(0, kinds.count("hull") - 1) + 2 * kinds.count("cylinder")
    if body.motion != "dynamic" or many > MAX_PIECES:
        return body
    return replace(body, pieces=tuple(part for piece in body.pieces for part in _parts(piece)))


def _parts(piece: CollisionShape) -> tuple[CollisionShape, ...]:
    if piece.kind != "cylinder":
        return (piece,)
    radius, height = piece.size
    overhang = min(END_OVERHANG, height / 100)
    half = radius * (1 - SIDE_CLEARANCE) / sqrt(2)
    return (
        replace(piece, size=(radius, height - 2 * overhang)),
        *(
            CollisionShape("box", (half, half, height / 2), _turned(piece, angle), piece.material)
            for angle in (0.0, OCTAGON_TURN)
        ),
    )


def _turned(piece: CollisionShape, angle: float) -> tuple[float, ...]:
    """Return the pose of a shape rotated about its z axis (rad)."""
    turn = multiply(np.array(piece.pose[3:]), np.array([cos(angle / 2), 0.0, 0.0, sin(angle / 2)]))
    return (*piece.pose[:3], *turn.tolist())
