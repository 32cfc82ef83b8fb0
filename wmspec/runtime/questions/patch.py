"""What a picture shows of a body: the patch of pixels that are its own."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from wmspec.core.memoize import cached_on
from wmspec.sim.scene.model import Frame


@dataclass(frozen=True)
class Patch:
    """`pixels` of a picture, a `share` of it, with their middle and their mean colour (0..1), None if there are none.

    `across` from the left edge, `down` from the top, as shares of the picture's sides. `rows` and `columns`: the first
    and the last with one of them.
    """

    pixels: int
    share: float
    across: float | None
    down: float | None
    color: tuple[float, ...] | None
    rows: tuple[int, int] = (0, -1)
    columns: tuple[int, int] = (0, -1)


def patch(frame: Frame, index: int) -> Patch:
    """What is seen of a body."""
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
