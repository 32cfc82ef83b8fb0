"""Differences of colours, also as protanopes and deuteranopes see them, and of the colours that name options."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from itertools import combinations

import numpy as np
from numpy.typing import ArrayLike

from wmspec.lang.check.tables.vocabulary import COLORS
from wmspec.runtime.questions.difference import ciede2000, lab
from wmspec.runtime.questions.legibility.bounds import entry
from wmspec.runtime.questions.model import Legibility, Option, VisibleObject
from wmspec.sim.scene.render.color import to_linear, to_srgb

_Color = tuple[float, ...]

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


def color_name_measures(options: Sequence[Option], pictures: Sequence[Sequence[VisibleObject]]) -> Iterator[Legibility]:
    """Yield the smallest difference between the colours that name options.

    The colour of an option is that of its object, or of an object with this colour, where it is drawn largest; if there
    is none, the colour of the word in the light that falls on the others.
    """
    words = [(option, word) for option in options for word in _color_words(option.text or "")]
    drawn = {word: color for option, word in words if (color := _drawn(option, word, pictures)) is not None}
    light = _light(drawn)
    named = {word: drawn.get(word, tuple(light * part for part in COLORS[word])) for _, word in words}
    for one, other in combinations(named.values(), 2):
        yield entry("color", difference(one, other))
        yield entry("color_dichromat", dichromat_difference(one, other))


def _light(drawn: Mapping[str, _Color]) -> float:
    """Return how light colours are drawn, relative to their words; 1 without any."""
    shares = [sum(color) / sum(COLORS[word]) for word, color in drawn.items()]
    return sum(shares) / len(shares) if shares else 1.0


def _color_words(text: str) -> list[str]:
    return [word for word in re.findall(r"\w+", text) if word in COLORS]


def _drawn(option: Option, word: str, pictures: Sequence[Sequence[VisibleObject]]) -> _Color | None:
    shown = [each for objects in pictures for each in objects if each.color is not None]
    own = [each for each in shown if each.name == option.name] or [each for each in shown if word in each.words]
    largest = max(own, key=lambda each: each.share, default=None)
    return None if largest is None else largest.color
