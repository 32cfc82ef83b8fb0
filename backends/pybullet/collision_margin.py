"""Compensates the collision margin that PyBullet adds to hulls of compound bodies.

Such hulls come from files, and no setting changes their margin. So they are shrunk by it.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from wmspec.sim.scene.physics.rigid import Assembly, CollisionShape, Rigid

Array = NDArray[np.float64]

MARGIN = 0.001  # m: `m_defaultCollisionMargin` of PyBullet for hulls from files
MAX_SHRINK = 0.5  # largest fraction of the thickness to remove


def shrink_by_margin(assembly: Assembly) -> Assembly:
    """Return the bodies with hulls shrunk where PyBullet adds a margin."""
    return replace(assembly, bodies=tuple(map(_body, assembly.bodies)))


def _body(body: Rigid) -> Rigid:
    if body.motion == "static" or len(body.pieces) < 2:  # single hulls come from numbers and have no margin
        return body
    return replace(body, pieces=tuple(_piece(p) if p.kind == "hull" else p for p in body.pieces))


def _piece(piece: CollisionShape) -> CollisionShape:
    from scipy.spatial import QhullError

    points = np.reshape(piece.size, (-1, 3))
    try:
        return replace(piece, size=tuple(_smaller(points).ravel().tolist()))
    except QhullError:  # too thin to shrink
        return piece


def _smaller(points: Array) -> Array:
    """Return the corners (n, 3) of a hull whose faces are moved inwards."""
    from scipy.spatial import ConvexHull, HalfspaceIntersection

    planes = np.unique(np.round(ConvexHull(points).equations, 9), axis=0)
    middle = points.mean(axis=0)
    room = -(planes[:, :3] @ middle + planes[:, 3]).max()
    planes[:, 3] += min(MARGIN, MAX_SHRINK * room)
    return np.unique(np.round(HalfspaceIntersection(planes, middle).intersections, 9), axis=0)
