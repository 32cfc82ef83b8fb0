"""Smooths what a path tracer drew with few paths, along surfaces and never across their edges.

The edge-avoiding à-trous wavelets of Dammertz, Sewtz, Hanika and Lensch (High Performance Graphics 2010), on light from
which the colours of the surfaces have been divided out, so that images on things stay sharp.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Picture = NDArray[np.float32]
"""(h, w, 3)."""

Planes = NDArray[np.float32]
"""The same, part by part: (n, h, w)."""

PASSES = 4
SPLINE = np.array([1, 4, 6, 4, 1], np.float32) / 16
PLANE, LIGHT = 0.004, 0.9
"""How fast the weight falls with the distance from the plane of the surface (as a share of that from the camera), and
with the difference of light (as a share of the light; less in every pass)."""

DARK, FIREFLY = 0.12, 2.0
"""Colours below are not divided out; light that is so many times the median around it, or such a part, is cut off."""


def denoise(light: Picture, color: Picture, normal: Picture, place: Picture) -> Picture:
    """The light (h, w, 3), smooth, given the `color`, `normal` and `place` (in the camera's axes) of what is seen."""
    color = np.maximum(color, np.float32(DARK))
    away = np.maximum(-place[..., 2], np.float32(1e-3)) * np.float32(PLANE)
    surface = np.concatenate([normal, place / away[..., None]], axis=2).transpose(2, 0, 1).copy()
    smooth = _calm((light / color).transpose(2, 0, 1))
    for turn in range(PASSES):
        smooth = _pass(smooth, surface, 2**turn, LIGHT / 1.5**turn)
    done: Picture = smooth.transpose(1, 2, 0) * color
    return done


def _calm(light: Planes) -> Planes:
    """Without the single pixels that a rare path made very bright, or none reached."""
    around, (height, width) = np.pad(light, ((0, 0), (1, 1), (1, 1)), mode="edge"), light.shape[1:]
    near = [around[:, i : i + height, j : j + width] for i in range(3) for j in range(3)]
    usual = np.median(near, axis=0)
    calm: Planes = np.clip(light, usual / np.float32(FIREFLY), np.float32(FIREFLY) * usual + np.float32(0.05))
    return calm


def _pass(light: Planes, surface: Planes, step: int, tolerance: float) -> Planes:
    """The mean of 5 x 5 pixels, `step` apart, each by how likely it is the same surface in the same light."""
    around = ((0, 0), (2 * step, 2 * step), (2 * step, 2 * step))
    lights, surfaces = np.pad(light, around, mode="edge"), np.pad(surface, around, mode="edge")
    height, width = light.shape[1:]
    total, weights = np.zeros_like(light), np.zeros_like(light[0])
    for i, row in enumerate(SPLINE):
        for j, column in enumerate(SPLINE):
            there = np.s_[:, i * step : i * step + height, j * step : j * step + width]
            weight = _likeness(light, lights[there], tolerance) * _closeness(surface, surfaces[there])
            weight = row * column * weight + np.float32(1e-6)
            total += weight * lights[there]
            weights += weight
    mean: Planes = total / weights
    return mean


def _closeness(one: Planes, other: Planes) -> NDArray[np.float32]:
    """1 on the same plane; less the more the normals differ (by a power of their cosine), and the farther it is off."""
    turned = np.clip(one[0] * other[0] + one[1] * other[1] + one[2] * other[2], 0, 1)
    for _ in range(5):
        turned *= turned
    off = one[0] * (other[3] - one[3]) + one[1] * (other[4] - one[4]) + one[2] * (other[5] - one[5])
    near: NDArray[np.float32] = turned / (1 + off * off)
    return near


def _likeness(one: Planes, other: Planes, tolerance: float) -> NDArray[np.float32]:
    """1 for equal light, less the more it differs."""
    bright, lit = one.sum(axis=0), other.sum(axis=0)
    apart = (bright - lit) / (np.float32(tolerance / 2) * (bright + lit) + np.float32(1e-3))
    alike: NDArray[np.float32] = 1 / (1 + apart * apart) ** 2
    return alike
