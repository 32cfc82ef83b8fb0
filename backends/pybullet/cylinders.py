"""Cylinders that stand and slide as they should: on two boxes inside them, whose corners reach to their rims.

Bullet finds the contacts of a flat round end one a step, and keeps older ones where they no longer are: what slides on
it is braked up to 8 % too much and turned aside. The contacts of boxes are found all at once, and are exact.
"""

from __future__ import annotations

from dataclasses import replace
from math import cos, pi, sin, sqrt

import numpy as np

from wmspec.sim.scene.model.transform import multiply
from wmspec.sim.scene.physics.rigid import Assembly, Piece, Rigid

from .info import MOST_PIECES

PROUD = 1e-5  # m: by how much the boxes stand out at the ends, where the cylinder itself then is not touched
INSIDE = 2e-3  # of the radius: how far the boxes stay within the side, on which the cylinder rolls
EIGHTH = pi / 4  # two squares, turned against each other by it, have the corners of an octagon


def footed(assembly: Assembly) -> Assembly:
    """The same bodies, with feet for the cylinders of those that are moved, as far as PyBullet takes so many pieces."""
    return replace(assembly, bodies=tuple(map(_body, assembly.bodies)))


def _body(body: Rigid) -> Rigid:
    kinds = [piece.kind for piece in body.pieces]
    many = len(kinds) - max(0, kinds.count("hull") - 1) + 2 * kinds.count("cylinder")
    if body.motion != "dynamic" or many > MOST_PIECES:
        return body
    return replace(body, pieces=tuple(part for piece in body.pieces for part in _parts(piece)))


def _parts(piece: Piece) -> tuple[Piece, ...]:
    if piece.kind != "cylinder":
        return (piece,)
    radius, height = piece.size
    proud = min(PROUD, height / 100)
    half = radius * (1 - INSIDE) / sqrt(2)
    return (
        replace(piece, size=(radius, height - 2 * proud)),
        *(Piece("box", (half, half, height / 2), _turned(piece, angle), piece.material) for angle in (0.0, EIGHTH)),
    )


def _turned(piece: Piece, angle: float) -> tuple[float, ...]:
    """The pose of a piece, turned about its own z (rad)."""
    turn = multiply(np.array(piece.pose[3:]), np.array([cos(angle / 2), 0.0, 0.0, sin(angle / 2)]))
    return (*piece.pose[:3], *turn.tolist())
