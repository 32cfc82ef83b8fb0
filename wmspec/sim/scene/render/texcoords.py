"""Texture coordinates of geoms: one image per side, or repeated per metre.

Texture coordinates are never negative, which TinyRenderer requires.
"""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache
from math import ceil

import numpy as np

from wmspec.sim.scene.model import Array, Geom
from wmspec.sim.shapes import Shape
from wmspec.sim.shapes.facets import MAX_CACHED_SHAPES, Facets, tessellate


def texcoords(geom: Geom) -> Facets:
    """Return the triangles of a geom with texture coordinates."""
    return _facets(geom.shape, geom.surface.repeats if geom.surface.texture is not None else None)


@lru_cache(maxsize=MAX_CACHED_SHAPES)
def _facets(shape: Shape, repeats: tuple[float, float] | None) -> Facets:
    facets = tessellate(shape)
    if repeats is None:
        return facets
    return replace(facets, st=_positive(shape.unwrapped(facets, np.array(repeats, dtype=np.float64))))


def _positive(st: Array) -> Array:
    """Return equivalent non-negative coordinates of a repeating image."""
    low = st.min(axis=0, initial=0.0)
    shifted: Array = st + [ceil(-value) for value in low.tolist()]
    return shifted
