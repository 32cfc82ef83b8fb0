"""Conversion of engine pixels to frames."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from wmspec.core.diagnostics import WmsError
from wmspec.sim.scene.model import Scene, Shot


def require_all_poses(scene: Scene, shot: Shot) -> None:
    """Raise WmsError unless the shot has a pose for every body of the scene."""
    if len(shot.poses) != len(scene.bodies):
        raise WmsError(
            f"a shot of '{scene.name}' has {len(shot.poses)} poses, expected one for each of {len(scene.bodies)} bodies"
        )


Image = NDArray[np.float32]


def blend_over(rgba: NDArray[np.uint8], color: tuple[float, float, float]) -> NDArray[np.uint8]:
    """Return a picture (h, w, 4), with alpha as coverage, blended over `color` (sRGB, 0..1)."""
    behind = np.rint(np.outer(255 - np.arange(256), color)).astype(np.uint8)
    rgb, share = rgba[..., :3].copy(), rgba[..., 3]
    seen = share < 255
    rgb[seen] += behind[share[seen]]
    return rgb


def halve(image: NDArray[np.uint8] | NDArray[np.bool_]) -> Image:
    """Return the mean of every 2 x 2 pixels: (2 h, 2 w, ...) to (h, w, ...)."""
    rows = np.add(image[0::2], image[1::2], dtype=np.uint16)
    mean: Image = (rows[:, 0::2] + rows[:, 1::2]).astype(np.float32) / np.float32(4)
    return mean


def quantize(rgb: Image) -> NDArray[np.uint8]:
    """Return the nearest bytes of values 0..255."""
    return np.rint(np.clip(rgb, 0.0, 255.0)).astype(np.uint8)
