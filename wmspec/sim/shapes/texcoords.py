"""How a repeated image lies on a shape, so many times on a metre.

It lies flat on the faces of a box, on caps and on meshes without texture coordinates of their own; around an axis it is
repeated a whole number of times, so that it closes, and along the axis from the bottom.
"""

from __future__ import annotations

from math import pi

import numpy as np
from numpy.typing import NDArray

from wmspec.sim.shapes.facets import Facets

Array = NDArray[np.float64]

_WAYS = {0: (1, 2), 1: (0, 2), 2: (0, 1)}
"""Axis of a flat side's normal -> the axes of the image's s and t."""


def flat(facets: Facets, every: Array) -> Array:
    """Seen along each normal's largest part: upright on the sides, +y up on top, never mirrored."""
    st = np.zeros_like(facets.st)
    largest = np.abs(facets.normals).argmax(axis=1)
    for axis, (right, up) in _WAYS.items():
        here = largest == axis
        outside = np.sign(facets.normals[here, axis]) * (-1 if axis == 1 else 1)
        st[here] = np.stack([facets.points[here, right] * outside, facets.points[here, up]], axis=1)
    turned: Array = st * every + 0.5
    return turned


def wound(facets: Facets, radius: float, length: float, every: Array) -> Array:
    """Around the axis, s a whole number of times, and t along a profile of `length` (m)."""
    around = max(1, round(2 * pi * radius * every[0]))
    st: Array = facets.st * [around, length * every[1]]
    return st


def capped(facets: Facets, radius: float, length: float, every: Array) -> Array:
    """Wound around the side, flat on the caps."""
    caps = np.abs(facets.normals[:, 2:]) > 1 - 1e-9
    st: Array = np.where(caps, flat(facets, every), wound(facets, radius, length, every))
    return st
