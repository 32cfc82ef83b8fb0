"""How an image lies on a geometry: once on each side, or repeated, so many times on a metre.

Texture coordinates are never negative, which TinyRenderer needs.
"""

from __future__ import annotations

from dataclasses import replace
from math import ceil

import numpy as np

from wmspec.scene.model import Array, Geom
from wmspec.shapes.facets import Facets, tessellate


def texcoords(geom: Geom) -> Facets:
    """The triangles of a geometry, with the texture coordinates at which its image is to be read."""
    facets, repeats = tessellate(geom.shape), geom.surface.repeats
    if geom.surface.texture is None or repeats is None:
        return facets
    st = geom.shape.unwrapped(facets, np.array(repeats, dtype=np.float64))
    return replace(facets, st=_positive(st))


def _positive(st: Array) -> Array:
    """The same place of the image, at coordinates that aren't negative."""
    low = st.min(axis=0, initial=0.0)
    shifted: Array = st + [ceil(-value) for value in low.tolist()]
    return shifted
