"""Referring expressions: colour and shape of an object, and further properties that distinguish it."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import cache, lru_cache

from wmspec.compile.layout.evaluator import Evaluator
from wmspec.compile.layout.geometry import volume
from wmspec.compile.layout.view import common_direction, view_coordinates
from wmspec.core.diagnostics import WmsError
from wmspec.lang.check.tables.color_math import rgb
from wmspec.lang.check.tables.vocabulary import COLORS
from wmspec.lang.check.types.types import article
from wmspec.runtime.questions.difference import ciede2000, lab
from wmspec.sim.materials import SHADES
from wmspec.sim.scene.model import Array

#: Ratio of edges above which an object is larger; offset (m) above which it is further to a side.
SIZE_RATIO, MIN_OFFSET = 1.15, 0.03

#: Adjectives of materials.
_MADE = {"wood": "wooden", "stripes": "striped", "checker": "checkered"}


class Ambiguous(WmsError):
    """No words distinguish two objects."""


def referring_expression(name: str, values: Evaluator) -> str:
    """Return words that describe exactly this object. Raises Ambiguous if there are none."""
    plain = _plain(name, values)
    rivals = [other for other in present_objects(values) if other != name and _plain(other, values) == plain]
    if not rivals:
        return f"the {plain}"
    for ways in (_material, _size, _side, _depth):
        for words in ways(name, rivals, values):
            return f"the {words}"
    raise Ambiguous(f"`{name}` and `{rivals[0]}` are both {article(plain)} and no words distinguish them")


def present_objects(values: Evaluator) -> Iterator[str]:
    """Yield the names of present objects."""
    for thing in values.spec.things:
        if thing.kind == "object" and values.is_present(thing.name):
            yield thing.name


@lru_cache(maxsize=4096)
def color_word(color: str) -> str:
    """Return the word of a colour, or of the most similar named colour."""
    if color in COLORS:
        return color
    if color in SHADES:
        return color.partition("_")[0]
    return min(_named(), key=lambda word: float(ciede2000(lab(rgb(color)), _named()[word])))


@cache
def _named() -> dict[str, Array]:
    """CIELAB of the named colours."""
    return {word: lab(color) for word, color in COLORS.items()}


def group_expression(names: Sequence[str], values: Evaluator) -> str | None:
    """Return words that describe exactly these objects, by colour and noun or by noun; None if there are none."""
    things = [values.spec.thing(name) for name in names]
    alike = len({thing.set or values.has(thing.name, "called") for thing in things}) == 1
    if len(names) < 2 or not alike or not (things[0].set or values.has(names[0], "called")):
        return None
    for words in (_plain, noun):
        first = words(names[0], values)
        fit = [other for other in present_objects(values) if words(other, values) == first]
        if sorted(fit) == sorted(names):
            own = noun(names[0], values)
            return f"the {first.removesuffix(own)}{_plural(names[0], own, values)}"
    return None


def _plural(name: str, noun: str, values: Evaluator) -> str:
    """Return the plural: from the spec, or by spelling rules."""
    if values.has(name, "plural"):
        return values.text(name, "plural")
    if noun.endswith(("s", "x", "ch", "sh")):
        return f"{noun}es"
    return f"{noun[:-1]}ies" if noun.endswith("y") and noun[-2:-1] not in "aeiou" else f"{noun}s"


def noun(name: str, values: Evaluator) -> str:
    """Return the noun of an object: its label, its shape, or its name if it has parts or is a mesh."""
    if values.has(name, "called"):
        return values.text(name, "called")
    if values.parts(name) or values.has(name, "file") or not values.has(name, "shape"):
        return name.replace("_", " ")
    return values.text(name, "shape")


def _plain(name: str, values: Evaluator) -> str:
    what = noun(name, values)
    formless = values.parts(name) or values.has(name, "file") or not values.has(name, "shape")
    if formless and not (values.has(name, "called") and values.has(name, "color")):
        return what
    return f"{color_word(values.text(name, 'color'))} {what}"


# ---------------------------------------------------------------- what tells apart


def _material(name: str, rivals: list[str], values: Evaluator) -> Iterator[str]:
    if not all(values.has(n, "material") for n in (name, *rivals)):
        return
    mine = values.text(name, "material")
    if all(values.text(other, "material") != mine for other in rivals):
        what = noun(name, values)
        yield f"{_plain(name, values).removesuffix(what)}{_MADE.get(mine, mine)} {what}"


def _size(name: str, rivals: list[str], values: Evaluator) -> Iterator[str]:
    def edge(n: str) -> float:
        return float(volume(values, n) ** (1 / 3))

    words = ("larger", "smaller") if len(rivals) == 1 else ("largest", "smallest")
    for word in _extreme(edge(name), [edge(r) for r in rivals], words, lambda a, b: a > b * SIZE_RATIO):
        yield f"{word} {_plain(name, values)}"


def _side(name: str, rivals: list[str], values: Evaluator) -> Iterator[str]:
    yield from _placed(name, rivals, values, 0, ("on the right", "on the left"))


def _depth(name: str, rivals: list[str], values: Evaluator) -> Iterator[str]:
    yield from _placed(name, rivals, values, 1, ("at the back", "at the front"))


def _placed(name: str, rivals: list[str], values: Evaluator, axis: int, words: tuple[str, str]) -> Iterator[str]:
    way = common_direction(values)
    here, *there = (view_coordinates(way, *values.pose(n).position[:2])[axis] for n in (name, *rivals))
    for word in _extreme(here, there, words, lambda a, b: a > b + MIN_OFFSET):
        yield f"{_plain(name, values)} {word}"


def _extreme(
    mine: float, others: list[float], words: tuple[str, str], beyond: Callable[[float, float], bool]
) -> Iterator[str]:
    if all(beyond(mine, other) for other in others):
        yield words[0]
    elif all(beyond(other, mine) for other in others):
        yield words[1]
