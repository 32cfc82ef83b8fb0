"""Visible rotation of bodies: none for a ball; only the axis direction for a cylinder."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from wmspec.sim.scene.model import Body
from wmspec.sim.scene.model.transform import rotate

Array = NDArray[np.float64]


def visible_angle(body: Body, a: Array, b: Array) -> Array:
    """Return the visible angle (T,), rad, between two orientations (T, 4) of a body."""
    return visible_angle_about(symmetry_axis(body), a, b)


def symmetry_axis(body: Body) -> Array:
    """Return the axis (3,) of rotational symmetry in the body frame; NaN for none, 0 for a ball."""
    seen = [g for g in body.geoms if g.visible]
    symmetry = seen[0].shape.symmetry if len(seen) == 1 else "none"
    if symmetry == "axis":
        return rotate(seen[0].pose.orientation, np.array([0.0, 0.0, 1.0]))
    return np.full(3, 0.0 if symmetry == "ball" else np.nan)


def visible_angle_about(symmetry_axis: Array, a: Array, b: Array) -> Array:
    """Return the visible angle (T,), rad, between orientations (T, 4) of a body with symmetry `axis` (3,)."""
    if not symmetry_axis.any():
        return np.zeros(len(a))
    if not np.isnan(symmetry_axis).any():
        return _between(rotate(a, symmetry_axis), rotate(b, symmetry_axis))
    return 2 * _between(a, b * np.where((a * b).sum(axis=1, keepdims=True) < 0, -1.0, 1.0))


def _between(a: Array, b: Array) -> Array:
    """Return the angle (T,) between unit vectors (T, n), accurate for small angles (Kahan, "Mangled angles", 2006)."""
    angle: Array = 2 * np.arctan2(np.linalg.norm(a - b, axis=1), np.linalg.norm(a + b, axis=1))
    return angle
