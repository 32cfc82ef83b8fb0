"""sRGB and linear light (IEC 61966-2-1), and texture images shared by all engines."""

from __future__ import annotations

from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from wmspec.core.diagnostics import WmsError
from wmspec.core.safe_io import load_image
from wmspec.sim.scene.model import Array


def to_linear(srgb: ArrayLike) -> Array:
    """Return linear light 0..1 of sRGB values 0..1."""
    value = np.asarray(srgb, dtype=np.float64)
    low: Array = value / 12.92
    high: Array = ((value + 0.055) / 1.055) ** 2.4
    return np.where(value <= 0.04045, low, high)


def to_srgb(linear: ArrayLike) -> Array:
    """Return sRGB values 0..1 of linear light 0..1; negative light counts as zero."""
    value = np.clip(np.asarray(linear, dtype=np.float64), 0.0, None)
    return np.where(value <= 0.0031308, value * 12.92, 1.055 * value ** (1 / 2.4) - 0.055)


def to_bytes(srgb: ArrayLike) -> NDArray[np.uint8]:
    """Return the nearest 8-bit values of sRGB values 0..1."""
    return np.rint(np.clip(np.asarray(srgb, dtype=np.float64), 0.0, 1.0) * 255).astype(np.uint8)


def round_up_color(srgb: tuple[float, float, float]) -> tuple[float, float, float]:
    """Return the colour of the nearest bytes plus a small margin, for engines that truncate."""
    red, green, blue = (min((round(255 * value) + 0.1) / 255, 1.0) for value in srgb)
    return red, green, blue


@lru_cache(maxsize=64)
def load_texture(path: str) -> NDArray[np.uint8]:
    """Return the image at `path` as (h, w, 3) sRGB bytes, top row first. Raises WmsError if it is unreadable."""
    try:
        pixels: Any = np.array(load_image(Path(path)).convert("RGB"), dtype=np.uint8)
    except WmsError as error:
        raise WmsError(f"the texture '{path}' is unreadable ({error}); expected the path of a PNG or JPEG") from error
    pixels.setflags(write=False)
    return np.asarray(pixels)
