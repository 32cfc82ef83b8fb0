"""Mipmaps for TinyRenderer, which samples single texels.

At a distance it would alias joints of tiles and speckles of stone. So repeated images come in several sizes, each half
of the previous one (Williams, "Pyramidal parametrics", SIGGRAPH 1983), and every side uses the one whose texels match
its pixels.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import PIL.Image
from numpy.typing import NDArray

from wmspec.core.native_output import silence
from wmspec.sim.scene.model import Array, Geom
from wmspec.sim.scene.render.color import load_texture
from wmspec.sim.shapes.facets import Facets

with silence():
    import pybullet

MIN_VIEW_SINE = 0.05
"""Smallest sine of the viewing angle of a side."""


class TextureCache:
    """Texture ids of a client; images are loaded on first use."""

    def __init__(self, client: int) -> None:
        self._client = client
        self._numbers: dict[tuple[str, int | None], int] = {}

    def number(self, file: str, halvings: int | None) -> int:
        """Return the texture of a file, optionally halved and smoothed. Raises WmsError if it is unreadable."""
        if (file, halvings) not in self._numbers:
            pixels = load_texture(file)
            with TemporaryDirectory() as folder:
                path = file if halvings is None else str(Path(folder) / "image.png")
                if halvings is not None:
                    PIL.Image.fromarray(smooth_tiled(downsample(pixels, halvings))).save(path, compress_level=1)
                self._numbers[file, halvings] = pybullet.loadTexture(path, physicsClientId=self._client)
        return self._numbers[file, halvings]


@dataclass(frozen=True)
class Pattern:
    """A repeated image on the sides of a geom.

    In the geom frame, sides lie in boxes `low` to `high` (n, 3) m and in `planes` (n, 4); `texels` (n,) per metre.
    """

    file: str
    low: Array
    high: Array
    planes: Array
    texels: Array

    @classmethod
    def of(cls, geom: Geom, sides: Sequence[Facets], planes: Array) -> Pattern | None:
        """Return the pattern of a geom; None if it has no repeated image."""
        look = geom.surface
        if look.texture is None or look.repeats is None:
            return None
        low, high = (np.array([ends(side.points, axis=0) for side in sides]) for ends in (np.min, np.max))
        size = float(np.prod(load_texture(look.texture).shape[:2]))
        return cls(look.texture, low, high, planes, np.sqrt([size * _share(side) for side in sides]))

    def halvings(self, eye: Array, pixel: float) -> list[int]:
        """Return the mipmap level of each side, seen from `eye` (3,) in the geom frame.

        `pixel` is the width of a pixel at a distance of 1 m.
        """
        away: Array = np.linalg.norm(np.clip(eye, self.low, self.high) - eye, axis=1)
        flat = self.planes[:, :3].any(axis=1)
        height = np.where(flat, self.planes @ np.append(eye, 1.0), away)
        covered = self.texels * pixel * away / np.clip(height / np.maximum(away, 1e-9), MIN_VIEW_SINE, 1)
        most = np.log2(max(load_texture(self.file).shape[:2]))
        halvings: list[int] = np.floor(np.clip(np.log2(np.maximum(covered, 1)), 0, most)).astype(int).tolist()
        return halvings


def _share(side: Facets) -> float:
    """Return the repetitions of the image per square metre."""
    ab, ac = (side.points[side.faces[:, i]] - side.points[side.faces[:, 0]] for i in (1, 2))
    st, uv = (side.st[side.faces[:, i]] - side.st[side.faces[:, 0]] for i in (1, 2))
    area = float(np.linalg.norm(np.cross(ab, ac), axis=1).sum())
    return float(np.abs(st[:, 0] * uv[:, 1] - st[:, 1] * uv[:, 0]).sum()) / area if area else 0.0


def downsample(image: NDArray[np.uint8], times: int) -> NDArray[np.uint8]:
    """Return means of 2 x 2 texels, `times` times: (h, w, 3) to (h >> times, w >> times, 3)."""
    height, width = (max(side >> times, 1) for side in image.shape[:2])
    return np.asarray(PIL.Image.fromarray(image).resize((width, height), PIL.Image.Resampling.BOX))


def smooth_tiled(image: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """Return a tiling image (h, w, 3) smoothed with weights 1, 2, 1 along both axes."""
    mean = image.astype(np.float64)
    for axis in (0, 1):
        mean = (np.roll(mean, 1, axis) + 2 * mean + np.roll(mean, -1, axis)) / 4
    return np.rint(mean).astype(np.uint8)
