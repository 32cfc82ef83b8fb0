"""How pictures are drawn, and who draws them."""

from __future__ import annotations

from functools import cache
from typing import TypedDict

from wmspec.core.diagnostics import WmsError
from wmspec.runtime.caches.render_cache import RenderCache
from wmspec.runtime.engines.registry import drawing
from wmspec.sim.scene.model import Look

#: How few and how many pixels the side of a picture may have.
LEAST_SIDE, MOST_SIDE = 16, 4096
#: How many it has if nobody says.
SIDE = 384


class Drawing(TypedDict, total=False):
    """How pictures are drawn.

    `size`: the side of a square, or (width, height), px; 384. `renderer`: the engine that draws, if not the one that
    executed. `look`: the same picture from every engine ("parity"), or a path-traced one by Mitsuba ("photo"), with so
    many `samples` a pixel.
    """

    size: int | tuple[int, int]
    renderer: str
    look: Look
    samples: int | None


def renderer_of(
    engine: str,
    *,
    size: int | tuple[int, int] = SIDE,
    renderer: str = "",
    look: Look = "parity",
    samples: int | None = None,
) -> RenderCache:
    """Who draws what an engine executed. Raises WmsError if it cannot be drawn so."""
    samples = samples_of(look, samples)
    (drawer,) = drawing((renderer or engine,), look)
    return _kept(drawer, *pixels(size), look, samples)


def pixels(size: int | tuple[int, int]) -> tuple[int, int]:
    """Width and height, px. Raises WmsError if they are too few or too many."""
    width, height = size if isinstance(size, tuple) else (size, size)
    if not all(LEAST_SIDE <= side <= MOST_SIDE for side in (width, height)):
        raise WmsError(f"size {width}x{height}: each side of a picture has {LEAST_SIDE} to {MOST_SIDE} pixels")
    return width, height


def samples_of(look: Look, samples: int | None) -> int | None:
    """The samples a pixel, if the look has any. Raises WmsError if not."""
    if look == "parity" and samples is not None:
        raise WmsError("the look `parity` has no samples to choose; leave them out, or draw with `--look photo`")
    return samples


@cache
def _kept(engine: str, width: int, height: int, look: Look, samples: int | None) -> RenderCache:
    """One renderer for all pictures that are drawn alike: making one takes longer than drawing."""
    return RenderCache(engine, width, height, look, samples)
