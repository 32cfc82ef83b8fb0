"""The tone curve of the photo look.

The highlight roll-off of Khronos' "PBR Neutral" tone mapper (2024); values below 0.76 of white keep their colour
exactly.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from wmspec.sim.scene.model import Array
from wmspec.sim.scene.render.color import to_bytes, to_srgb

START, DESATURATION = 0.76, 0.15


def tonemap(light: Array) -> NDArray[np.uint8]:
    """Return the bytes (h, w, 3) of linear light (h, w, 3), where 1 is a white surface that faces the sun."""
    peak = light.max(axis=-1, keepdims=True)
    beyond = np.maximum(peak, START) - START
    rolled = 1 - (1 - START) ** 2 / (beyond + 1 - START)
    white = 1 - 1 / (DESATURATION * (beyond + START - rolled) + 1)
    bright = light * rolled / np.maximum(peak, START)
    return to_bytes(to_srgb(np.where(peak < START, light, bright + white * (rolled - bright))))
