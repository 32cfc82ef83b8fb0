"""Cylinders that roll: PhysX's are prisms, which brake as they roll; a capsule inside is what they roll on.

A capsule as thick as the cylinder reaches its side and, unless the cylinder is a disc, stays within its ends. The
prism, a little thinner then, is what it stands on.
"""

from __future__ import annotations

from dataclasses import replace

from wmspec.scene.hard import disc
from wmspec.scene.rigid import Assembly, Piece, Rigid

THINNER = 2e-3  # of the radius: how far the prism stays within the side
SHORTER = 1e-4  # m: how far the capsule stays within the ends, where there is room
SHORTEST = 1e-6  # m: of its straight part


def barrels(assembly: Assembly) -> Assembly:
    """The same bodies, with capsules in the cylinders of those that move."""
    return replace(assembly, bodies=tuple(map(_body, assembly.bodies)))


def _body(body: Rigid) -> Rigid:
    if body.motion == "static":
        return body
    return replace(body, pieces=tuple(part for piece in body.pieces for part in _parts(piece)))


def _parts(piece: Piece) -> tuple[Piece, ...]:
    if piece.kind != "cylinder" or disc(*piece.size):
        return (piece,)
    radius, height = piece.size
    prism = replace(piece, size=(radius * (1 - THINNER), height))
    straight = max(height - 2 * (radius + SHORTER), SHORTEST)
    return prism, replace(piece, kind="capsule", size=(radius, straight))
