"""How far a body is turned, as far as that can be seen: a ball shows nothing, a cylinder only where its axis points."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from wmspec.sim.scene.model import Body
from wmspec.sim.scene.model.transform import rotate

Array = NDArray[np.float64]


def turned(body: Body, a: Array, b: Array) -> Array:
    """The visible angle (T,) in radians between two orientations (T, 4) of a body."""
    return visibly_turned(axis(body), a, b)


def axis(body: Body) -> Array:
    """About what a body can turn unseen (3,): its axis, in its frame; nothing (NaN), or anything (0)."""
    seen = [g for g in body.geoms if g.visible]
    symmetry = seen[0].shape.symmetry if len(seen) == 1 else "none"
    if symmetry == "axis":
        return rotate(seen[0].pose.orientation, np.array([0.0, 0.0, 1.0]))
    return np.full(3, 0.0 if symmetry == "ball" else np.nan)


def visibly_turned(axis: Array, a: Array, b: Array) -> Array:
    """The visible angle (T,) in radians between orientations (T, 4) of what can turn unseen about `axis` (3,)."""
    if not axis.any():
        return np.zeros(len(a))
    if not np.isnan(axis).any():
        return _between(rotate(a, axis), rotate(b, axis))
    return 2 * _between(a, b * np.where((a * b).sum(axis=1, keepdims=True) < 0, -1.0, 1.0))


def _between(a: Array, b: Array) -> Array:
    """The angle (T,) between unit vectors (T, n), exact for small ones too (Kahan, "Mangled angles", 2006)."""
    angle: Array = 2 * np.arctan2(np.linalg.norm(a - b, axis=1), np.linalg.norm(a + b, axis=1))
    return angle
