"""What lights a scene: the sun as a soft disc, and a bright room or sky around, as one map of all directions."""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from wmspec.sim.scene.model import Array, Light
from wmspec.sim.scene.render.color import to_linear
from wmspec.sim.scene.render.environment import radiance

ROWS = 256
"""Of the map, from straight up to straight down; twice as many columns."""

SUN, SKY = 1.0, 1.25
"""How much stronger than in the parity look the light is, since its bytes are not linear."""

SUN_COLOR, SUN_RADIUS = np.array([1.0, 0.95, 0.87]), math.radians(2.5)
"""The sun is five times as wide as the real one in a hazy sky: the softness of its shadows."""

CEILING, BELOW = 2.0, 0.01
"""What is wider than this (m) both ways and above the camera is a ceiling; light comes from so far below it."""

HINT = 0.3
"""So much of the hue of the background has the light from above: outdoors it is the sky's."""


def directions(rows: int) -> Array:
    """Unit directions (rows, 2 rows, 3) of the texels of Mitsuba's map, z up, once it is turned by 90° about x."""
    v, u = np.meshgrid((np.arange(rows) + 0.5) / rows, (np.arange(2 * rows) + 0.5) / (2 * rows), indexing="ij")
    azimuth, polar = u * 2 * math.pi, v * math.pi
    toward: Array = np.stack([np.sin(azimuth) * np.sin(polar), np.cos(azimuth) * np.sin(polar), np.cos(polar)], axis=-1)
    return toward


def surroundings(light: Light, background: tuple[float, float, float], rows: int = ROWS) -> NDArray[np.float32]:
    """Linear radiance (rows, 2 rows, 3) from everywhere, where 1 is a white surface that is fully lit."""
    toward = directions(rows)
    image = radiance(toward) * _hue(toward, background) * (light.ambient * SKY)
    away = np.arccos(np.clip(toward @ -light.direction, -1, 1))
    disc = np.clip((SUN_RADIUS - away) / (math.pi / rows) + 0.5, 0, 1)
    solid = np.sin((np.arange(rows) + 0.5) / rows * math.pi)[:, None] * (math.pi / rows) ** 2 * disc
    # A white surface that faces the sun reflects `diffuse` of it: its irradiance is pi times that.
    sun = SUN_COLOR * (math.pi * light.diffuse * SUN / solid.sum())
    lit: NDArray[np.float32] = (image + disc[..., None] * sun).astype(np.float32)
    return lit


def panels(light: Light, bounds: Iterable[tuple[Array, Array]], eye: Array) -> list[tuple[Array, Array]]:
    """The undersides, as opposite corners (3,), of what light without shadows shines through: ceilings above an eye.

    `bounds` are the lowest and highest corners of what stands still.
    """
    if light.shadows:
        return []
    above = [(low, high) for low, high in bounds if low[2] > eye[2] and (high - low)[:2].min() > CEILING]
    over = [(low, high) for low, high in above if (low[:2] < eye[:2]).all() and (eye[:2] < high[:2]).all()]
    return [(low - [0, 0, BELOW], np.array([*high[:2], low[2] - BELOW])) for low, high in over]


def _hue(toward: Array, background: tuple[float, float, float]) -> Array:
    """What the light from each direction (..., 3) is multiplied by: of the mean 1 over the colours."""
    color = to_linear(background) + 1e-3
    above = np.clip(toward[..., 2:] * 4 + 0.5, 0, 1)
    hue: Array = 1 + HINT * above * (color / color.mean() - 1)
    return hue
