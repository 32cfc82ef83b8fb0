"""Differences of drawn texture: spread and grain of lightness."""

from __future__ import annotations

import numpy as np

from wmspec.core.memoize import cached_on
from wmspec.runtime.questions.difference import lab_of_bytes
from wmspec.sim.scene.model import Array, Frame

#: Quantiles at which two distributions of lightness are compared.
_QUANTILES = np.linspace(0.05, 0.95, 19)


def texture_difference(frame: Frame, a: int, b: int) -> float:
    """Return the difference (L*) of two bodies in a picture in the spread or in the grain of lightness, if larger.

    The spread is the distribution about the median, the grain that of steps between neighbouring pixels. Distributions
    are compared by the mean difference of their quantiles (Wasserstein distance).
    """
    one, other = cached_on(frame, _distributions, a), cached_on(frame, _distributions, b)
    return float(np.abs(one - other).mean(axis=1).max())


def _distributions(frame: Frame, index: int) -> Array:
    """Return the quantiles (2, q) of the lightness of a body about its median, and of its steps; 0 if not drawn."""
    mask = frame.ids == index
    light = lab_of_bytes(frame.rgb)[..., 0]
    steps = np.concatenate(
        [
            np.abs(light[1:] - light[:-1])[mask[1:] & mask[:-1]],
            np.abs(light[:, 1:] - light[:, :-1])[mask[:, 1:] & mask[:, :-1]],
        ]
    )
    spread = light[mask] - np.median(light[mask]) if mask.any() else np.zeros(1)
    return np.stack([np.quantile(each, _QUANTILES) for each in (spread, steps if len(steps) else np.zeros(1))])
