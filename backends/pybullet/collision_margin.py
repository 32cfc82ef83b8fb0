"""Hulls that are as large in PyBullet as they are: it puts a margin around those that a body has several of.

Such hulls come from files, and no setting reaches their margin. So they are made smaller by as much.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import ConvexHull, HalfspaceIntersection, QhullError

from wmspec.sim.scene.physics.rigid import Assembly, Piece, Rigid

Array = NDArray[np.float64]

MARGIN = 0.001  # m: of hulls from files, `m_defaultCollisionMargin` in PyBullet
MOST = 0.5  # of what is thin, the part that may be taken off


def within_margins(assembly: Assembly) -> Assembly:
    """The same bodies, hulls smaller where PyBullet adds a margin."""
    return replace(assembly, bodies=tuple(map(_body, assembly.bodies)))


def _body(body: Rigid) -> Rigid:
    if body.motion == "static" or len(body.pieces) < 2:  # those have hulls from numbers, without a margin
        return body
    return replace(body, pieces=tuple(_piece(p) if p.kind == "hull" else p for p in body.pieces))


def _piece(piece: Piece) -> Piece:
    points = np.reshape(piece.size, (-1, 3))
    try:
        return replace(piece, size=tuple(_smaller(points).ravel().tolist()))
    except QhullError:  # so thin that there is nothing to take off
        return piece


def _smaller(points: Array) -> Array:
    """The corners (n, 3) of a hull whose faces are moved inwards."""
    planes = np.unique(np.round(ConvexHull(points).equations, 9), axis=0)
    middle = points.mean(axis=0)
    room = -(planes[:, :3] @ middle + planes[:, 3]).max()
    planes[:, 3] += min(MARGIN, MOST * room)
    return np.unique(np.round(HalfspaceIntersection(planes, middle).intersections, 9), axis=0)
