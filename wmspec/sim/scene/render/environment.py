"""What surrounds a scene in the photo look: a bright room without colour, which lights things and is mirrored by them.

The light comes from a pale ceiling, two large windows and their reflections on the floor, so that metal and gloss have
something to mirror. Directions are the world's, z up; radiance is linear, its mean over the upper half about 1.
"""

from __future__ import annotations

import numpy as np

from wmspec.sim.scene.model import Array

PEAK = 4.0
"""No radiance is more than this."""

_WINDOWS = ((-2.5, 0.62, 0.48, 0.30, 3.4), (0.35, 0.75, 0.30, 0.34, 2.6))
"""Azimuth and elevation of their middles, half their width and height (radians), and how bright they are."""


def radiance(directions: Array) -> Array:
    """Linear radiance (..., 3) that comes from unit `directions` (..., 3)."""
    x, y, z = np.moveaxis(directions, -1, 0)
    azimuth, elevation = np.arctan2(y, x), np.arcsin(np.clip(z, -1, 1))
    grey = np.where(z > 0, 0.62 + 0.5 * z, 0.62 - 0.34 * _step(-z, 0.02, 0.35))
    for middle, up, wide, high, bright in _WINDOWS:
        aside = np.abs((azimuth - middle + np.pi) % (2 * np.pi) - np.pi)
        inside = _step(wide - aside, -0.03, 0.03) * _step(high - np.abs(elevation - up), -0.03, 0.03)
        grey = grey + (bright - grey) * inside
    tint = np.where(z[..., None] > 0, np.array([0.985, 1.0, 1.02]), np.array([1.03, 1.0, 0.96]))
    light: Array = np.clip(grey[..., None] * tint, 0, PEAK)
    return light


def _step(value: Array, low: float, high: float) -> Array:
    """0 below `low`, 1 above `high`, smooth in between."""
    t = np.clip((value - low) / (high - low), 0, 1)
    smooth: Array = t * t * (3 - 2 * t)
    return smooth
