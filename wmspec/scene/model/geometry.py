"""Places and shapes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Pose:
    """A rigid placement: `position` (3,) in metres, `orientation` (4,) a unit quaternion (w, x, y, z)."""

    position: Array
    orientation: Array


@dataclass(frozen=True)
class Box:
    """An axis-aligned box with half-extents `half` (3,)."""

    half: Array


@dataclass(frozen=True)
class Sphere:
    """A sphere around the origin."""

    radius: float


@dataclass(frozen=True)
class Cylinder:
    """A cylinder along z, centred: its caps lie at ±height / 2."""

    radius: float
    height: float


@dataclass(frozen=True)
class Cone:
    """A cone along z, centred on half its height: base at -height / 2, apex at +height / 2."""

    radius: float
    height: float


@dataclass(frozen=True)
class Capsule:
    """A capsule along z, centred: `height` is the length of the straight part."""

    radius: float
    height: float


@dataclass(frozen=True)
class Mesh:
    """A triangle mesh: `points` (n, 3), `faces` (m, 3) vertex indices, `st` (n, 2) or None.

    Collides as its convex hull.
    """

    points: Array
    faces: NDArray[np.int32]
    st: Array | None = None


Shape = Box | Sphere | Cylinder | Cone | Capsule | Mesh
