"""Soft edges of shadows, equal in all engines: the map of the sun is compared at three by three texels.

Percentage-closer filtering (Reeves et al., "Rendering antialiased shadows with depth maps", SIGGRAPH 1987). Most points
are lit or shaded as a whole; only those at an edge need all nine texels.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from wmspec.sim.scene.render.picture import Image

REACH = 1.5
"""Texels around a point that decide on its shadow."""


def deciding_texels(places: Image, side: int) -> slice:
    """Return the rows, or columns, of a map of `side` texels that decide on the shadows of points at `places`."""
    first, last = (np.clip(np.floor(bound), -2, side + 1) for bound in (places.min(), places.max()))
    return slice(max(int(first) - 1, 0), min(int(last) + 2, side))


def occlusion(x: Image, y: Image, away: Image, seen: NDArray[np.float32], origin: tuple[int, int] = (0, 0)) -> Image:
    """Return the shaded fraction (h, w), 0..1, of points at `away` (h, w) from the sun.

    `x` and `y` (h, w) are their places in the map in texels: texel i covers [i, i + 1). `seen` (m, n) is what the sun
    sees in the rows and columns from `origin` on, `inf` for nothing, in the unit of `away`. What is outside is lit.
    """
    # around the map nothing is, as far as the neighbours of clipped places
    framed = np.pad(seen, 3, constant_values=np.inf)
    row, column = (
        np.clip(np.floor(at) - first, -2, side + 1).astype(np.intp) + 3
        for at, first, side in zip((y, x), origin, seen.shape, strict=True)
    )
    place = row * framed.shape[1] + column
    nearest, farthest = _around(framed, np.minimum), _around(framed, np.maximum)
    shaded: Image = (farthest.take(place) < away).astype(np.float32)
    edge = np.flatnonzero((nearest.take(place) < away) & (shaded == 0))
    if len(edge):
        right, down = (part.take(edge) - np.floor(part.take(edge)) for part in (x, y))
        shaded.flat[edge] = _share(framed, place.take(edge), right, down, away.take(edge))
    return shaded


def _around(texels: NDArray[np.float32], choose: np.ufunc) -> NDArray[np.float32]:
    """Return the least or greatest of three by three texels; the frame stays as it is."""
    found, wide = texels.copy(), texels.copy()
    choose(choose(texels[:, :-2], texels[:, 1:-1]), texels[:, 2:], out=wide[:, 1:-1])
    choose(choose(wide[:-2], wide[1:-1]), wide[2:], out=found[1:-1])
    return found


def _share(texels: NDArray[np.float32], place: NDArray[np.intp], right: Image, down: Image, away: Image) -> Image:
    """Return the weighted fraction of three by three texels around `place` (n,) that is nearer than `away` (n,).

    `right` and `down` (n,), 0..1, are the places within the middle texel; weights are linear in them.
    """
    share: Image = np.zeros_like(away)
    flat, wide = texels.ravel(), texels.shape[1]
    for below, across in zip((-1, 0, 1), _weights(down), strict=True):
        for beside, weight in zip((-1, 0, 1), _weights(right), strict=True):
            share += (flat.take(place + below * wide + beside) < away) * (across * weight)
    return share


def _weights(inside: Image) -> tuple[Image | np.float32, ...]:
    """Return the weights of three texels for a place within the middle one."""
    half = np.float32(0.5)
    return (1 - inside) * half, half, inside * half
