"""Colours that name the options of a question: whether the drawn colours can be distinguished, also by dichromats."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from itertools import combinations

from wmspec.lang.check.tables.vocabulary import COLORS
from wmspec.runtime.questions.legibility.bounds import entry
from wmspec.runtime.questions.legibility.color_vision import dichromat_difference, difference
from wmspec.runtime.questions.model import Legibility, Option, VisibleObject

_Color = tuple[float, ...]


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
