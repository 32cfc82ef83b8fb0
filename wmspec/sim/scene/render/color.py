"""sRGB and linear light (IEC 61966-2-1), and the texture images that all engines share."""

from __future__ import annotations

from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from wmspec.core.diagnostics import WmsError
from wmspec.core.safe_io import picture
from wmspec.sim.scene.model import Array


def to_linear(srgb: ArrayLike) -> Array:
    """Linear light 0..1 of sRGB values 0..1, any shape."""
    value = np.asarray(srgb, dtype=np.float64)
    low: Array = value / 12.92
    high: Array = ((value + 0.055) / 1.055) ** 2.4
    return np.where(value <= 0.04045, low, high)


def to_srgb(linear: ArrayLike) -> Array:
    """SRGB values 0..1 of linear light 0..1 (negative light counts as none), any shape."""
    value = np.clip(np.asarray(linear, dtype=np.float64), 0.0, None)
    return np.where(value <= 0.0031308, value * 12.92, 1.055 * value ** (1 / 2.4) - 0.055)


def to_bytes(srgb: ArrayLike) -> NDArray[np.uint8]:
    """Nearest 8-bit values of sRGB values 0..1, any shape."""
    return np.rint(np.clip(np.asarray(srgb, dtype=np.float64), 0.0, 1.0) * 255).astype(np.uint8)


def whole(srgb: tuple[float, float, float]) -> tuple[float, float, float]:
    """The colour of the nearest bytes, from a little above, for engines that cut fractions of a byte off."""
    red, green, blue = (min((round(255 * value) + 0.1) / 255, 1.0) for value in srgb)
    return red, green, blue


@lru_cache(maxsize=64)
def texture(path: str) -> NDArray[np.uint8]:
    """The image at `path` as (h, w, 3) sRGB bytes, first row on top. Raises WmsError if it can't be read."""
    try:
        pixels: Any = np.array(picture(Path(path)).convert("RGB"), dtype=np.uint8)
    except WmsError as error:
        raise WmsError(f"the texture '{path}' can't be read ({error}); expected the path of a PNG or JPEG") from error
    pixels.setflags(write=False)
    return np.asarray(pixels)
