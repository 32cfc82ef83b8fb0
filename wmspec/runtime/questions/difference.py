"""Colour differences: CIELAB and CIEDE2000."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from wmspec.sim.scene.model import Array
from wmspec.sim.scene.render.color import to_linear

#: Linear sRGB to CIE XYZ, and the D65 white (IEC 61966-2-1).
_XYZ = np.array(
    [[0.4124564, 0.3575761, 0.1804375], [0.2126729, 0.7151522, 0.0721750], [0.0193339, 0.1191920, 0.9503041]]
)
_WHITE = _XYZ.sum(axis=1)
#: Linear light of the 256 byte values.
_LINEAR = to_linear(np.arange(256) / 255.0)


def lab(srgb: ArrayLike) -> Array:
    """Return CIELAB (..., 3) of sRGB values 0..1 (..., 3)."""
    return _lab(to_linear(srgb))


def lab_of_bytes(srgb: NDArray[np.uint8]) -> Array:
    """Return CIELAB (..., 3) of sRGB bytes (..., 3)."""
    return _lab(_LINEAR[srgb])


def _lab(linear: Array) -> Array:
    ratio = linear @ _XYZ.T / _WHITE
    f = np.where(ratio > (6 / 29) ** 3, np.cbrt(ratio), ratio / (3 * (6 / 29) ** 2) + 4 / 29)
    x, y, z = f[..., 0], f[..., 1], f[..., 2]
    return np.stack([116 * y - 16, 500 * (x - y), 200 * (y - z)], axis=-1)


def ciede2000(a: ArrayLike, b: ArrayLike) -> Array:
    """Return the CIEDE2000 difference of CIELAB colours (..., 3): 1 is just noticeable, 5 visible at a glance.

    Sharma, Wu and Dalal, "The CIEDE2000 color-difference formula", Color Research & Application 30, 2005.
    """
    one, other = np.asarray(a, float), np.asarray(b, float)
    (l1, a1, b1), (l2, a2, b2) = ((v[..., 0], v[..., 1], v[..., 2]) for v in (one, other))
    c7 = ((np.hypot(a1, b1) + np.hypot(a2, b2)) / 2) ** 7
    stretch = 1.5 - 0.5 * np.sqrt(c7 / (c7 + 25.0**7))
    c1, c2 = np.hypot(stretch * a1, b1), np.hypot(stretch * a2, b2)
    h1, h2 = np.arctan2(b1, stretch * a1), np.arctan2(b2, stretch * a2)
    turn = (h2 - h1 + np.pi) % (2 * np.pi) - np.pi
    gray = c1 * c2 == 0
    turn = np.where(gray, 0.0, turn)
    lightness, chroma, hue = l2 - l1, c2 - c1, 2 * np.sqrt(c1 * c2) * np.sin(turn / 2)
    l_, c_ = (l1 + l2) / 2, (c1 + c2) / 2
    h_ = np.where(gray, h1 + h2, h1 + turn / 2)
    t = (
        1
        - 0.17 * np.cos(h_ - np.radians(30))
        + 0.24 * np.cos(2 * h_)
        + 0.32 * np.cos(3 * h_ + np.radians(6))
        - 0.20 * np.cos(4 * h_ - np.radians(63))
    )
    around = (np.degrees(h_) % 360 - 275) / 25
    c_7 = c_**7
    rotation = -np.sin(np.radians(60) * np.exp(-(around**2))) * 2 * np.sqrt(c_7 / (c_7 + 25.0**7))
    lightness = lightness / (1 + 0.015 * (l_ - 50) ** 2 / np.sqrt(20 + (l_ - 50) ** 2))
    chroma, hue = chroma / (1 + 0.045 * c_), hue / (1 + 0.015 * c_ * t)
    return np.asarray(np.sqrt(lightness**2 + chroma**2 + hue**2 + rotation * chroma * hue))
