"""Who looks, in which light, and what is seen."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from wmspec.sim.scene.model.geometry import Array, Pose


@dataclass(frozen=True)
class Camera:
    """A pinhole camera in USD's axes (looks along -z, +y up); `fovy` in radians, vertical.

    `pose` is in the frame of the `body` that it rides on, or in the world.
    """

    name: str
    pose: Pose
    fovy: float
    near: float
    far: float
    body: str | None = None


@dataclass(frozen=True)
class Light:
    """The sun: unit `direction` (3,) in which the light goes; `diffuse` + `ambient` = 1 lights a facing white fully.

    Without `shadows` it shines through everything, as light from all around seems to.
    """

    direction: Array
    diffuse: float = 0.65
    ambient: float = 0.35
    shadows: bool = True


@dataclass(frozen=True)
class Observation:
    """The stage's own list of pictures to take: camera name and times (s)."""

    name: str
    camera: str
    times: tuple[float, ...]


@dataclass(frozen=True)
class Shot:
    """A picture asked for: which camera, and where every body of the scene is."""

    camera: str
    poses: Sequence[Pose]


@dataclass(frozen=True)
class Frame:
    """A picture.

    `rgb` (h, w, 3) uint8; `ids` (h, w) int16, the index of the body seen, -1 for the background; `depth` (h, w)
    float32 in metres along the view axis, 0 for the background, or None if it was not asked for.
    """

    rgb: NDArray[np.uint8]
    ids: NDArray[np.int16]
    depth: NDArray[np.float32] | None = field(default=None)
