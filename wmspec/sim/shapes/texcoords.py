"""Texture coordinates of repeated images.

Images are planar on box faces, caps and meshes without texture coordinates. Around an axis they repeat a whole number
of times, so that they close, and along the axis from the bottom.
"""

from __future__ import annotations

from math import pi

import numpy as np
from numpy.typing import NDArray

from wmspec.sim.shapes.facets import Facets

Array = NDArray[np.float64]

_WAYS = {0: (1, 2), 1: (0, 2), 2: (0, 1)}
"""Axis of a face normal -> axes of s and t."""


def planar_texcoords(facets: Facets, every: Array) -> Array:
    """Return coordinates projected along the largest component of each normal: upright on sides, +y up on top."""
    st = np.zeros_like(facets.st)
    largest = np.abs(facets.normals).argmax(axis=1)
    for axis, (right, up) in _WAYS.items():
        here = largest == axis
        outside = np.sign(facets.normals[here, axis]) * (-1 if axis == 1 else 1)
        st[here] = np.stack([facets.points[here, right] * outside, facets.points[here, up]], axis=1)
    turned: Array = st * every + 0.5
    return turned


def wrapped_texcoords(facets: Facets, radius: float, length: float, every: Array) -> Array:
    """Return coordinates around the axis, s a whole number of times, t along a profile of `length` (m)."""
    around = max(1, round(2 * pi * radius * every[0]))
    st: Array = facets.st * [around, length * every[1]]
    return st


def capped_texcoords(facets: Facets, radius: float, length: float, every: Array) -> Array:
    """Return coordinates wrapped around the side and planar on the caps."""
    caps = np.abs(facets.normals[:, 2:]) > 1 - 1e-9
    st: Array = np.where(caps, planar_texcoords(facets, every), wrapped_texcoords(facets, radius, length, every))
    return st
