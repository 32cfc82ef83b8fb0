"""The pixels of a body in a picture."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from wmspec.core.memoize import cached_on
from wmspec.sim.scene.model import Frame


@dataclass(frozen=True)
class Patch:
    """`pixels` of a body, their `share` of the picture, centre and mean colour (0..1); None without pixels.

    `across` and `down` are relative to the picture size, from left and top. `rows` and `columns`: first and last.
    """

    pixels: int
    share: float
    across: float | None
    down: float | None
    color: tuple[float, ...] | None
    rows: tuple[int, int] = (0, -1)
    columns: tuple[int, int] = (0, -1)


def patch(frame: Frame, index: int) -> Patch:
    """Return the patch of a body."""
    return cached_on(frame, _patch, index)


def _patch(frame: Frame, index: int) -> Patch:
    own = np.flatnonzero(frame.ids == index)
    pixels = len(own)
    if not pixels:
        return Patch(0, 0.0, None, None, None)
    height, width = frame.ids.shape
    rows, columns = np.divmod(own, width)
    across, down = (
        float((int(places.sum()) / pixels + 0.5) / side) for places, side in ((columns, width), (rows, height))
    )
    color = frame.rgb.reshape(-1, 3)[own].mean(axis=0) / 255.0
    high, wide = (int(rows[0]), int(rows[-1])), (int(columns.min()), int(columns.max()))
    return Patch(pixels, pixels / frame.ids.size, across, down, tuple(map(float, color)), high, wide)
