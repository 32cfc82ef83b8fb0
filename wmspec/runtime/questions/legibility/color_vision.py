"""Colours as protanopes and deuteranopes see them."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from wmspec.runtime.questions.difference import ciede2000, lab
from wmspec.sim.scene.render.color import to_linear, to_srgb

#: Linear sRGB to what dichromats see, at full severity (Machado, Oliveira and Fernandes, "A Physiologically-based Model
#: for Simulation of Color Vision Deficiency", IEEE Transactions on Visualization and Computer Graphics 15, 2009).
#: The values equal severity 1.0 of `CVD_MATRICES_MACHADO2010` in colour-science.
DICHROMACY = {
    "protanopia": np.array(
        [[0.152286, 1.052583, -0.204868], [0.114503, 0.786281, 0.099216], [-0.003882, -0.048116, 1.051998]]
    ),
    "deuteranopia": np.array(
        [[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413], [-0.011820, 0.042940, 0.968881]]
    ),
}


def difference(a: ArrayLike, b: ArrayLike) -> float:
    """Return the CIEDE2000 difference of two sRGB colours (3,), 0..1."""
    return float(ciede2000(lab(a), lab(b)))


def dichromat_difference(a: ArrayLike, b: ArrayLike) -> float:
    """Return the smaller CIEDE2000 difference of two sRGB colours (3,), 0..1, for protanopes and deuteranopes."""
    return min(difference(_simulated(a, kind), _simulated(b, kind)) for kind in DICHROMACY)


def _simulated(srgb: ArrayLike, kind: str) -> ArrayLike:
    return np.clip(to_srgb(DICHROMACY[kind] @ to_linear(srgb)), 0.0, 1.0)
