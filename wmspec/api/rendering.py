"""Options of rendering, and the renderer for them."""

from __future__ import annotations

from typing import TypedDict

from wmspec.core.diagnostics import WmsError
from wmspec.core.memoize import LRU
from wmspec.runtime.caches.render_cache import RenderCache
from wmspec.runtime.engines.registry import require_look
from wmspec.sim.scene.model import Look

#: The smallest and the largest side of a picture, in pixels.
MIN_SIDE, MAX_SIDE = 16, 4096
#: The default side, in pixels.
DEFAULT_SIDE = 384
#: Maximum number of renderers kept: each holds pictures and the graphics memory of an engine.
MAX_RENDERERS = 4
#: The renderers that were used last, by their options: creating one takes longer than drawing.
_renderers: LRU[tuple[str, int, int, Look, int | None], RenderCache] = LRU(MAX_RENDERERS, drop=RenderCache.close)


class RenderOptions(TypedDict, total=False):
    """Options of rendering.

    `size`: the side of a square, or (width, height), in pixels; 384 by default. `renderer`: the engine that draws, by
    default the one that executed. `look`: "parity", equal in all engines, or "photo", path-traced by Mitsuba with this
    many `samples` per pixel.
    """

    size: int | tuple[int, int]
    renderer: str
    look: Look
    samples: int | None


def renderer_of(
    engine: str,
    *,
    size: int | tuple[int, int] = DEFAULT_SIDE,
    renderer: str = "",
    look: Look = "parity",
    samples: int | None = None,
) -> RenderCache:
    """Return the renderer for episodes of an engine. Raises WmsError if it does not support these options."""
    samples = check_samples(look, samples)
    (drawer,) = require_look((renderer or engine,), look)
    options = (drawer, *pixels(size), look, samples)
    return _renderers.get(options, lambda: RenderCache(*options))


def pixels(size: int | tuple[int, int]) -> tuple[int, int]:
    """Return width and height in pixels. Raises WmsError if they are out of range."""
    width, height = size if isinstance(size, tuple) else (size, size)
    if not all(MIN_SIDE <= side <= MAX_SIDE for side in (width, height)):
        raise WmsError(f"size {width}x{height}: each side of a picture has {MIN_SIDE} to {MAX_SIDE} pixels")
    return width, height


def check_samples(look: Look, samples: int | None) -> int | None:
    """Return the samples per pixel. Raises WmsError if the look has none."""
    if look == "parity" and samples is not None:
        raise WmsError("the look `parity` has no samples; omit them, or use `--look photo`")
    return samples
