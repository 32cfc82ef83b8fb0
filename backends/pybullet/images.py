"""Images for TinyRenderer, which takes one texel where others take the mean of all that a pixel covers.

Afar it would see a joint of tiles or none, and speckles in stone. So images that are repeated come in several sizes,
each half of the one before ("mipmaps": Williams, "Pyramidal parametrics", SIGGRAPH 1983), and every side of a thing
wears the one whose texels are as large as the pixels that see it.
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
from wmspec.sim.scene.render.color import texture
from wmspec.sim.shapes.facets import Facets

with silence():
    import pybullet

FLATTEST = 0.05
"""The least sine of the angle at which a side is taken to be seen."""


class Images:
    """A client's numbers of images; each is loaded when it is first wanted."""

    def __init__(self, client: int) -> None:
        self._client = client
        self._numbers: dict[tuple[str, int | None], int] = {}

    def number(self, file: str, halvings: int | None) -> int:
        """The image of a file, as it is or halved so often and softened. Raises WmsError if it can't be read."""
        if (file, halvings) not in self._numbers:
            pixels = texture(file)
            with TemporaryDirectory() as folder:
                path = file if halvings is None else str(Path(folder) / "image.png")
                if halvings is not None:
                    PIL.Image.fromarray(soft(halved(pixels, halvings))).save(path, compress_level=1)
                self._numbers[file, halvings] = pybullet.loadTexture(path, physicsClientId=self._client)
        return self._numbers[file, halvings]


@dataclass(frozen=True)
class Pattern:
    """An image that is repeated on the sides of a geometry.

    In the geometry's frame the sides lie in the boxes from `low` to `high` (n, 3) m and in `planes` (n, 4); on a metre
    of each there are so many `texels` (n,).
    """

    file: str
    low: Array
    high: Array
    planes: Array
    texels: Array

    @classmethod
    def of(cls, geom: Geom, sides: Sequence[Facets], planes: Array) -> Pattern | None:
        """What is on a geometry, None if it has no image or one that is not repeated."""
        look = geom.surface
        if look.texture is None or look.repeats is None:
            return None
        low, high = (np.array([ends(side.points, axis=0) for side in sides]) for ends in (np.min, np.max))
        size = float(np.prod(texture(look.texture).shape[:2]))
        return cls(look.texture, low, high, planes, np.sqrt([size * _share(side) for side in sides]))

    def halvings(self, eye: Array, pixel: float) -> list[int]:
        """How often the image of each side is to be halved, seen from `eye` (3,) in the geometry's frame.

        `pixel` is the width of a pixel at a distance of 1 m.
        """
        away: Array = np.linalg.norm(np.clip(eye, self.low, self.high) - eye, axis=1)
        flat = self.planes[:, :3].any(axis=1)
        height = np.where(flat, self.planes @ np.append(eye, 1.0), away)
        covered = self.texels * pixel * away / np.clip(height / np.maximum(away, 1e-9), FLATTEST, 1)
        most = np.log2(max(texture(self.file).shape[:2]))
        halvings: list[int] = np.floor(np.clip(np.log2(np.maximum(covered, 1)), 0, most)).astype(int).tolist()
        return halvings


def _share(side: Facets) -> float:
    """How many times an image is on a square metre of triangles."""
    ab, ac = (side.points[side.faces[:, i]] - side.points[side.faces[:, 0]] for i in (1, 2))
    st, uv = (side.st[side.faces[:, i]] - side.st[side.faces[:, 0]] for i in (1, 2))
    area = float(np.linalg.norm(np.cross(ab, ac), axis=1).sum())
    return float(np.abs(st[:, 0] * uv[:, 1] - st[:, 1] * uv[:, 0]).sum()) / area if area else 0.0


def halved(image: NDArray[np.uint8], times: int) -> NDArray[np.uint8]:
    """The means of 2 x 2 texels, taken so many times: (h, w, 3) to (h >> times, w >> times, 3)."""
    height, width = (max(side >> times, 1) for side in image.shape[:2])
    return np.asarray(PIL.Image.fromarray(image).resize((width, height), PIL.Image.Resampling.BOX))


def soft(image: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """The mean of every texel of a repeated image (h, w, 3) and its neighbours, which weigh half, across and down."""
    mean = image.astype(np.float64)
    for axis in (0, 1):
        mean = (np.roll(mean, 1, axis) + 2 * mean + np.roll(mean, -1, axis)) / 4
    return np.rint(mean).astype(np.uint8)
