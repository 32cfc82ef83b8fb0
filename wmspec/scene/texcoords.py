"""How an image lies on a shape: once on each side, or repeated, so many times on a metre.

Repeated, an image lies flat on the faces of a box, on caps and on meshes without texture coordinates of their own;
around an axis it is repeated a whole number of times, so that it closes, and along the axis from the bottom. Texture
coordinates are never negative, which TinyRenderer needs.
"""

from __future__ import annotations

from dataclasses import replace
from math import ceil, hypot, pi

import numpy as np

from wmspec.scene.model import Array, Box, Capsule, Cone, Cylinder, Geom, Mesh, Sphere
from wmspec.scene.tessellate import Facets, tessellate

_WAYS = {0: (1, 2), 1: (0, 2), 2: (0, 1)}
"""Axis of a flat side's normal -> the axes of the image's s and t."""


def unwrap(geom: Geom) -> Facets:
    """The triangles of a geometry, with the texture coordinates at which its image is to be read."""
    facets, repeats = tessellate(geom.shape), geom.surface.repeats
    if geom.surface.texture is None or repeats is None:
        return facets
    every = np.array(repeats, dtype=np.float64)
    match geom.shape:
        case Mesh() if geom.shape.st is not None:
            st = facets.st * every
        case Box() | Mesh():
            st = _flat(facets, every)
        case Sphere() | Capsule():
            straight = geom.shape.height if isinstance(geom.shape, Capsule) else 0.0
            st = _wound(facets, geom.shape.radius, pi * geom.shape.radius + straight, every)
        case Cylinder() | Cone():
            st = _capped(facets, geom.shape, every)
    return replace(facets, st=_positive(st))


def _wound(facets: Facets, radius: float, length: float, every: Array) -> Array:
    """Around the axis, s a whole number of times, and t along a profile of `length` (m)."""
    around = max(1, round(2 * pi * radius * every[0]))
    st: Array = facets.st * [around, length * every[1]]
    return st


def _capped(facets: Facets, shape: Cylinder | Cone, every: Array) -> Array:
    length = shape.height if isinstance(shape, Cylinder) else hypot(shape.height, shape.radius)
    caps = np.abs(facets.normals[:, 2:]) > 1 - 1e-9
    st: Array = np.where(caps, _flat(facets, every), _wound(facets, shape.radius, length, every))
    return st


def _flat(facets: Facets, every: Array) -> Array:
    """Seen along each normal's largest part: upright on the sides, +y up on top, never mirrored."""
    st = np.zeros_like(facets.st)
    largest = np.abs(facets.normals).argmax(axis=1)
    for axis, (right, up) in _WAYS.items():
        here = largest == axis
        outside = np.sign(facets.normals[here, axis]) * (-1 if axis == 1 else 1)
        st[here] = np.stack([facets.points[here, right] * outside, facets.points[here, up]], axis=1)
    turned: Array = st * every + 0.5
    return turned


def _positive(st: Array) -> Array:
    """The same place of the image, at coordinates that aren't negative."""
    low = st.min(axis=0, initial=0.0)
    shifted: Array = st + [ceil(-value) for value in low.tolist()]
    return shifted
