"""Cameras, light, and pictures."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from wmspec.sim.scene.model.geometry import Array, Pose


@dataclass(frozen=True)
class Camera:
    """A pinhole camera in USD's axes (looks along -z, +y up); `fovy` in radians, vertical.

    `pose` is in the frame of `body` if the camera is attached to one, else in the world.
    """

    name: str
    pose: Pose
    fovy: float
    near: float
    far: float
    body: str | None = None


@dataclass(frozen=True)
class Light:
    """The sun: unit `direction` (3,) of its light; `diffuse` + `ambient` = 1 lights a facing white surface fully.

    Without `shadows` it approximates light from all directions.
    """

    direction: Array
    diffuse: float = 0.4
    ambient: float = 0.6
    shadows: bool = True


@dataclass(frozen=True)
class Observation:
    """Pictures that the stage prescribes: camera name and times (s)."""

    name: str
    camera: str
    times: tuple[float, ...]


@dataclass(frozen=True)
class Shot:
    """A request to render: the camera, and the poses of all bodies."""

    camera: str
    poses: Sequence[Pose]


@dataclass(frozen=True)
class Frame:
    """A rendered picture.

    `rgb` (h, w, 3) uint8; `ids` (h, w) int16, the index of the visible body, -1 for the background; `depth` (h, w)
    float32 in metres along the view axis, 0 for the background, or None if it was not requested.
    """

    rgb: NDArray[np.uint8]
    ids: NDArray[np.int16]
    depth: NDArray[np.float32] | None = field(default=None)
