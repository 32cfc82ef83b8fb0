"""How an image lies on a geometry: once on each side, or repeated, so many times on a metre.

Texture coordinates are never negative, which TinyRenderer needs.
"""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache
from math import ceil

import numpy as np

from wmspec.sim.scene.model import Array, Geom
from wmspec.sim.shapes import Shape
from wmspec.sim.shapes.facets import KEPT, Facets, tessellate


def texcoords(geom: Geom) -> Facets:
    """The triangles of a geometry, with the texture coordinates at which its image is to be read."""
    return _facets(geom.shape, geom.surface.repeats if geom.surface.texture is not None else None)


@lru_cache(maxsize=KEPT)
def _facets(shape: Shape, repeats: tuple[float, float] | None) -> Facets:
    facets = tessellate(shape)
    if repeats is None:
        return facets
    return replace(facets, st=_positive(shape.unwrapped(facets, np.array(repeats, dtype=np.float64))))


def _positive(st: Array) -> Array:
    """The same place of the image, at coordinates that aren't negative."""
    low = st.min(axis=0, initial=0.0)
    shifted: Array = st + [ceil(-value) for value in low.tolist()]
    return shifted
