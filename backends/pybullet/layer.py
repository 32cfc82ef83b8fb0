"""Pictures with depth that can be composited: static bodies are not drawn again for every shot."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class DepthLayer:
    """TinyRenderer output: `rgba` (h, w, 4), `depth` (h, w) 0..1, PyBullet's `numbers` (h, w), -1 for none."""

    rgba: NDArray[np.uint8]
    depth: NDArray[np.float32]
    numbers: NDArray[np.int32]

    @classmethod
    def of(cls, image: Sequence[Any]) -> DepthLayer:
        """Return the layer of a `getCameraImage` result: arrays, or flat tuples if PyBullet was built without NumPy."""
        width, height, rgba, depth, numbers = image
        return cls(
            np.asarray(rgba, np.uint8).reshape(height, width, 4),
            np.asarray(depth, np.float32).reshape(height, width),
            np.asarray(numbers, np.int32).reshape(height, width),
        )

    def over(self, other: DepthLayer) -> DepthLayer:
        """Return the nearer of both at every pixel, equal to drawing both at once."""
        near = (self.numbers >= 0) & (self.depth < other.depth)
        whole = np.where(near, self.rgba.view(np.uint32)[..., 0], other.rgba.view(np.uint32)[..., 0])
        return DepthLayer(
            whole[..., None].view(np.uint8),
            np.where(near, self.depth, other.depth),
            np.where(near, self.numbers, other.numbers),
        )
