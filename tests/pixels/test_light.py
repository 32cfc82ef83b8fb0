"""The light of the photo look: what surrounds a scene, and how light becomes a picture."""

from __future__ import annotations

import math

import numpy as np
import pytest

from wmspec.sim.photo.light import MAX_RADIANCE, directions, radiance
from wmspec.sim.photo.tracer import tonemap


def test_the_surroundings_have_a_mean_radiance_of_one() -> None:
    """The mean over the upper half of the sphere."""
    toward = directions(64)
    solid = np.broadcast_to(np.sin((np.arange(64) + 0.5) / 64 * math.pi)[:, None], (64, 128))
    light, upper = radiance(toward), toward[..., 2] > 0
    assert (light[upper].mean(axis=-1) * solid[upper]).sum() / solid[upper].sum() == pytest.approx(1, abs=0.15)
    assert light.max() <= MAX_RADIANCE


def test_the_tone_curve_keeps_dark_colours_and_compresses_bright_ones() -> None:
    dark, bright = np.array([[[0.2, 0.5, 0.1]]]), np.linspace(0.1, 8, 50)[None, :, None] * np.ones(3)
    assert np.allclose(tonemap(dark)[0, 0], [124, 188, 89], atol=1)  # IEC 61966-2-1
    curve = tonemap(bright)[0, :, 0].astype(int)
    assert np.all(np.diff(curve) >= 0)
    assert curve[-1] <= 255
    assert np.unique(curve).size > 8
