"""Arrays and poses."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Pose:
    """A rigid transform: `position` (3,) in metres, `orientation` (4,) a unit quaternion (w, x, y, z)."""

    position: Array
    orientation: Array
