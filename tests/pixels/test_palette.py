"""The colours of the language are told apart by everybody, and shades of one colour come in even steps."""

from __future__ import annotations

from itertools import combinations
from typing import Any

import numpy as np
import pytest

from wmspec.lang.check.tables.colors import rgb
from wmspec.lang.check.tables.vocabulary import COLORS, WORDS
from wmspec.runtime.questions.difference import ciede2000, lab
from wmspec.sim.materials import DISTINCT_COLORS, SHADES
from wmspec.sim.scene.render.color import to_linear, to_srgb

#: Machado, Oliveira and Fernandes, "A physiologically-based model for simulation of color vision deficiency", IEEE TVCG
#: 15, 2009: on linear light, at full severity.
DEFICIENCIES = {
    "none": np.eye(3),
    "protan": [[0.152286, 1.052583, -0.204868], [0.114503, 0.786281, 0.099216], [-0.003882, -0.048116, 1.051998]],
    "deutan": [[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413], [-0.011820, 0.042940, 0.968881]],
    "tritan": [[1.255528, -0.076749, -0.178779], [-0.078411, 0.930809, 0.147602], [0.004733, 0.691367, 0.303900]],
}


def seen(color: Any, deficiency: str) -> Any:
    """CIELAB of a colour as seen with a deficiency."""
    return lab(to_srgb(np.clip(np.asarray(DEFICIENCIES[deficiency]) @ to_linear(color), 0, 1)))


@pytest.mark.parametrize("deficiency", DEFICIENCIES)
def test_question_colours_are_told_apart(deficiency: str) -> None:
    bar = 16 if deficiency == "none" else 9.5
    for one, other in combinations(DISTINCT_COLORS, 2):
        apart = ciede2000(seen(COLORS[one], deficiency), seen(COLORS[other], deficiency))
        assert apart >= bar, f"{one} and {other}: {apart:.1f}"


@pytest.mark.parametrize("deficiency", DEFICIENCIES)
def test_shades_come_in_order_and_are_told_apart(deficiency: str) -> None:
    labs = np.array([seen(color, deficiency) for color in SHADES.values()])
    assert np.all(np.diff(labs[:, 0]) < -8), "every shade is darker than the one before"
    assert ciede2000(labs[1:], labs[:-1]).min() > 8


def test_shades_come_in_even_steps() -> None:
    labs = np.array([lab(color) for color in SHADES.values()])
    steps = ciede2000(labs[1:], labs[:-1])
    assert steps.max() / steps.min() < 1.1


def test_shades_are_words_of_the_language() -> None:
    for name, color in SHADES.items():
        assert name in WORDS["color"]
        assert rgb(name) == color
