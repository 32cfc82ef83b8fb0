"""Lighting: the sun as a soft disc, and a bright room or sky as an environment map."""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from wmspec.sim.scene.model import Array, Light
from wmspec.sim.scene.render.color import to_linear

ROWS = 256
"""Rows of the map from zenith to nadir; it has twice as many columns."""

SUN, SKY = 1.0, 1.25
"""Gain over the light of the parity look."""

SUN_COLOR, SUN_RADIUS = np.array([1.0, 0.95, 0.87]), math.radians(2.5)
"""Five times as wide as the real sun in a hazy sky, for soft shadows."""

MIN_CEILING, LAMP_OFFSET = 2.0, 0.01
"""m: static bodies above the camera wider in both directions are ceilings; light starts `LAMP_OFFSET` below."""

MAX_RADIANCE = 4.0
"""Upper bound of radiance."""

_WINDOWS = ((-2.5, 0.62, 0.48, 0.30, 3.4), (0.35, 0.75, 0.30, 0.34, 2.6))
"""Azimuth and elevation of the centre, half width and height (rad), and brightness of each window."""

SKY_TINT = 0.3
"""Fraction of the background hue in the light from above, as under a sky."""


def directions(rows: int) -> Array:
    """Return unit directions (rows, 2 rows, 3) of Mitsuba's map texels, z up, for a map rotated by 90° about x."""
    v, u = np.meshgrid((np.arange(rows) + 0.5) / rows, (np.arange(2 * rows) + 0.5) / (2 * rows), indexing="ij")
    azimuth, polar = u * 2 * math.pi, v * math.pi
    toward: Array = np.stack([np.sin(azimuth) * np.sin(polar), np.cos(azimuth) * np.sin(polar), np.cos(polar)], axis=-1)
    return toward


def strengths(light: Light) -> tuple[float, float]:
    """Return the linear strengths of sun and sky: light of the parity look adds up in sRGB."""
    shaded, lit = (float(part) for part in to_linear((light.ambient, light.ambient + light.diffuse)))
    return (lit - shaded) * SUN, shaded * SKY


def environment_map(light: Light, background: tuple[float, float, float], rows: int = ROWS) -> NDArray[np.float32]:
    """Return linear radiance (rows, 2 rows, 3); 1 is a fully lit white surface."""
    toward = directions(rows)
    direct, ambient = strengths(light)
    image = radiance(toward) * _hue(toward, background) * ambient
    away = np.arccos(np.clip(toward @ -light.direction, -1, 1))
    disc = np.clip((SUN_RADIUS - away) / (math.pi / rows) + 0.5, 0, 1)
    solid = np.sin((np.arange(rows) + 0.5) / rows * math.pi)[:, None] * (math.pi / rows) ** 2 * disc
    # a facing white surface reflects `direct`; its irradiance is pi times that
    sun = SUN_COLOR * (math.pi * direct / solid.sum())
    lit: NDArray[np.float32] = (image + disc[..., None] * sun).astype(np.float32)
    return lit


def radiance(directions: Array) -> Array:
    """Return linear radiance (..., 3) of a bright neutral room from unit `directions` (..., 3) in world axes, z up.

    Light comes from a pale ceiling, two large windows and their reflections on the floor. The mean over the upper
    half is about 1.
    """
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


def ceiling_lights(light: Light, bounds: Iterable[tuple[Array, Array]], eye: Array) -> list[tuple[Array, Array]]:
    """Return undersides of ceilings above `eye` as opposite corners (3,), for light without shadows.

    `bounds` are lowest and highest corners of static bodies.
    """
    if light.shadows:
        return []
    above = [(low, high) for low, high in bounds if low[2] > eye[2] and (high - low)[:2].min() > MIN_CEILING]
    over = [(low, high) for low, high in above if (low[:2] < eye[:2]).all() and (eye[:2] < high[:2]).all()]
    return [(low - [0, 0, LAMP_OFFSET], np.array([*high[:2], low[2] - LAMP_OFFSET])) for low, high in over]


def _hue(toward: Array, background: tuple[float, float, float]) -> Array:
    """Return the colour factor (..., 3) of light from each direction, with mean 1."""
    color = to_linear(background) + 1e-3
    above = np.clip(toward[..., 2:] * 4 + 0.5, 0, 1)
    hue: Array = 1 + SKY_TINT * above * (color / color.mean() - 1)
    return hue


def _step(value: Array, low: float, high: float) -> Array:
    """Return a smooth step: 0 below `low`, 1 above `high`."""
    t = np.clip((value - low) / (high - low), 0, 1)
    smooth: Array = t * t * (3 - 2 * t)
    return smooth
