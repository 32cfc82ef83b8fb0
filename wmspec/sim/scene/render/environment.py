"""The environment of the photo look: a bright neutral room that lights the scene and is reflected by it.

Light comes from a pale ceiling, two large windows and their reflections on the floor. Directions are in world axes, z
up; radiance is linear with a mean of about 1 over the upper half.
"""

from __future__ import annotations

import numpy as np

from wmspec.sim.scene.model import Array

MAX_RADIANCE = 4.0
"""Upper bound of radiance."""

_WINDOWS = ((-2.5, 0.62, 0.48, 0.30, 3.4), (0.35, 0.75, 0.30, 0.34, 2.6))
"""Azimuth and elevation of the centre, half width and height (rad), and brightness of each window."""


def radiance(directions: Array) -> Array:
    """Return linear radiance (..., 3) from unit `directions` (..., 3)."""
    x, y, z = np.moveaxis(directions, -1, 0)
    azimuth, elevation = np.arctan2(y, x), np.arcsin(np.clip(z, -1, 1))
    grey = np.where(z > 0, 0.62 + 0.5 * z, 0.62 - 0.34 * _step(-z, 0.02, 0.35))
    for middle, up, wide, high, bright in _WINDOWS:
        aside = np.abs((azimuth - middle + np.pi) % (2 * np.pi) - np.pi)
        inside = _step(wide - aside, -0.03, 0.03) * _step(high - np.abs(elevation - up), -0.03, 0.03)
        grey = grey + (bright - grey) * inside
    tint = np.where(z[..., None] > 0, np.array([0.985, 1.0, 1.02]), np.array([1.03, 1.0, 0.96]))
    light: Array = np.clip(grey[..., None] * tint, 0, MAX_RADIANCE)
    return light


def _step(value: Array, low: float, high: float) -> Array:
    """Return a smooth step: 0 below `low`, 1 above `high`."""
    t = np.clip((value - low) / (high - low), 0, 1)
    smooth: Array = t * t * (3 - 2 * t)
    return smooth
