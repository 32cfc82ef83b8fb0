"""The surroundings as Filament wants them: a KTX file of a cube map, blurrier from level to level, and its irradiance.

Level k of n is what a surface of roughness k / (n - 1) mirrors. The irradiance is in nine spherical harmonics
(Ramamoorthi & Hanrahan, "An efficient representation for irradiance environment maps", 2001), scaled as
Filament's `cmgen` does.
"""

from __future__ import annotations

import struct
from functools import cache

import numpy as np
from numpy.typing import NDArray

from wmspec.scene.environment import cube, radiance
from wmspec.scene.model import Array

SIDES = (64, 32, 16, 8, 4)
FINE = 24
"""The side of the cube that blurred levels and irradiance are summed over."""

_MARK = b"\xabKTX 11\xbb\r\n\x1a\n"
_R11F_G11F_B10F, _RGB = 0x8C3A, 0x1907
_COSINE = (1.0, 2 / 3, 1 / 4)
"""Of a cosine lobe, the part in each band of spherical harmonics, over pi."""


@cache
def environment() -> bytes:
    """The file."""
    harmonics = b"sh\0" + "\n".join(" ".join(f"{v:.6g}" for v in row) for row in _irradiance()).encode() + b"\n\0"
    padded = harmonics + bytes(-len(harmonics) % 4)
    metadata = struct.pack("<I", len(harmonics)) + padded
    head = (0x04030201, _R11F_G11F_B10F, 1, _RGB, _R11F_G11F_B10F, _R11F_G11F_B10F)
    size = (SIDES[0], SIDES[0], 0, 0, 6, len(SIDES), len(metadata))
    levels = (_level(k) for k in range(len(SIDES)))
    data = b"".join(struct.pack("<I", 4 * SIDES[k] ** 2) + _packed(level) for k, level in enumerate(levels))
    return _MARK + struct.pack("<13I", *head, *size) + metadata + data


def _texels(side: int) -> tuple[Array, Array]:
    """Directions (n, 3) of the texels of a cube, and the solid angles (n,) they stand for."""
    directions = cube(side)
    area = (4 / side**2) * np.abs(directions).max(axis=-1) ** 3
    return directions.reshape(-1, 3), area.reshape(-1)


def _arriving(directions: Array) -> Array:
    """The surroundings in Filament's axes, in which y is up."""
    x, y, z = np.moveaxis(directions, -1, 0)
    return radiance(np.stack([x, -z, y], axis=-1))


def _level(k: int) -> Array:
    """Radiance (6 s s, 3), spread over the lobe of the level's roughness."""
    directions, _ = _texels(SIDES[k])
    if k == 0:
        return _arriving(directions)
    fine, area = _texels(FINE)
    spread = (k / (len(SIDES) - 1)) ** 2
    weight = np.exp((directions @ fine.T - 1) * 2 / spread**2) * area
    blurred: Array = weight @ _arriving(fine) / weight.sum(axis=1, keepdims=True)
    return blurred


def _irradiance() -> Array:
    """Nine coefficients (9, 3): irradiance over pi, as a polynomial of the normal."""
    directions, area = _texels(FINE)
    x, y, z = directions.T
    one = np.ones_like(x)
    basis = np.stack([one, y, z, x, y * x, y * z, 3 * z * z - 1, z * x, x * x - y * y])
    norm = (area * basis**2).sum(axis=1)
    band = np.repeat(_COSINE, (1, 3, 5))
    coefficients: Array = (basis * area) @ _arriving(directions) * (band / norm)[:, None]
    return coefficients


def _packed(light: Array) -> bytes:
    """Three floats of 11, 11 and 10 bits a texel: 5 bits of exponent each, no sign."""
    halves: NDArray[np.uint32] = light.astype(np.float16).view(np.uint16).astype(np.uint32)
    red, green, blue = halves.T
    packed: NDArray[np.uint32] = (red >> 4) | ((green >> 4) << 11) | ((blue >> 5) << 22)
    return packed.astype("<u4").tobytes()
