"""Everybody can distinguish the colours of the language, and shades of one colour come in even steps."""

from __future__ import annotations

import re
from itertools import combinations
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from wmspec.lang.check.tables.color_math import rgb
from wmspec.lang.check.tables.vocabulary import COLORS, WORDS
from wmspec.lang.parse.files import library_folder
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


#: Mean light on objects in the pictures of the libraries, relative to a surface of the colour itself.
SHADING, UNEVEN = (0.74, 1.06), 1.16
#: Names that are options together.
HUES = ("red", "orange", "yellow", "green", "cyan", "blue", "purple", "pink")


def seen(color: Any, deficiency: str) -> Any:
    """CIELAB of a colour as seen with a deficiency."""
    return lab(to_srgb(np.clip(to_linear(color) @ np.array(DEFICIENCIES[deficiency]).T, 0, 1)))


@pytest.mark.parametrize("deficiency", DEFICIENCIES)
def test_question_colours_are_distinguishable(deficiency: str) -> None:
    bar = 16 if deficiency == "none" else 9.5
    for one, other in combinations(DISTINCT_COLORS, 2):
        apart = ciede2000(seen(COLORS[one], deficiency), seen(COLORS[other], deficiency))
        assert apart >= bar, f"{one} and {other}: {apart:.1f}"


@pytest.mark.parametrize("deficiency", ["none", "protan", "deutan"])
def test_names_stay_apart_in_light_and_shade(deficiency: str) -> None:
    """The parity look multiplies sRGB by the light. In one picture objects differ in it by `UNEVEN` at most."""
    light = np.linspace(*SHADING, 12)
    together = np.abs(np.log(light[:, None] / light)) <= np.log(UNEVEN)
    normal = deficiency == "none"
    for one, other in combinations(DISTINCT_COLORS if normal else HUES, 2):
        first, second = (seen(np.clip(np.outer(light, COLORS[name]), 0, 1), deficiency) for name in (one, other))
        apart = ciede2000(first[:, None], second[None])
        assert apart[slice(None) if normal else together].min() >= (15 if normal else 7.5), (one, other, apart.min())


@pytest.mark.parametrize("name", DISTINCT_COLORS)
@pytest.mark.parametrize("light", [0.6, 0.8, 1.06])
def test_a_name_holds_in_the_shade(name: str, light: float) -> None:
    """Orange is not brown where only ambient light reaches it: of the colours in mean light its own is the nearest."""
    drawn = lab(np.clip(np.array(COLORS[name]) * light, 0, 1))
    apart = {other: float(ciede2000(drawn, lab(np.array(COLORS[other]) * 0.82))) for other in DISTINCT_COLORS}
    assert min(apart, key=lambda other: apart[other]) == name


@pytest.mark.parametrize("path", sorted(library_folder().glob("*.wms")), ids=lambda path: path.stem)
def test_the_lights_of_libraries_keep_names_in_the_shade(path: Path) -> None:
    """As much ambient light as `test_a_name_holds_in_the_shade` supposes."""
    for found in re.findall(r"ambient: ([\d.]+)|ambient: pick\(\[(.*?)\]", path.read_text()):
        assert min(float(part) for part in "".join(found).split(",")) >= 0.6


@pytest.mark.parametrize("deficiency", DEFICIENCIES)
def test_shades_are_ordered_and_distinguishable(deficiency: str) -> None:
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
