"""Colours that name the options of a question: whether the drawn colours can be distinguished, also by dichromats."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from itertools import combinations

from wmspec.lang.check.tables.vocabulary import COLORS
from wmspec.runtime.questions.legibility.bounds import entry
from wmspec.runtime.questions.legibility.color_vision import dichromat_difference, difference
from wmspec.runtime.questions.model import Legibility, Option, VisibleObject

_Color = tuple[float, ...]


def color_name_measures(options: Sequence[Option], pictures: Sequence[Sequence[VisibleObject]]) -> Iterator[Legibility]:
    """Yield the smallest difference between the colours that name options.

    The colour of an option is that of its object, or of an object with this colour, where it is drawn largest; if there
    is none, the colour of the word.
    """
    named = {word: _drawn(option, word, pictures) for option in options for word in _color_words(option.text or "")}
    for one, other in combinations(named.values(), 2):
        yield entry("color", difference(one, other))
        yield entry("color_dichromat", dichromat_difference(one, other))


def _color_words(text: str) -> list[str]:
    return [word for word in re.findall(r"\w+", text) if word in COLORS]


def _drawn(option: Option, word: str, pictures: Sequence[Sequence[VisibleObject]]) -> _Color:
    shown = [each for objects in pictures for each in objects if each.color is not None]
    own = [each for each in shown if each.name == option.name] or [each for each in shown if word in each.words]
    largest = max(own, key=lambda each: each.share, default=None)
    return COLORS[word] if largest is None or largest.color is None else largest.color
