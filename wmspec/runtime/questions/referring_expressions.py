"""Objects in words: by colour and shape, and by what else it takes to tell one from the others."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import cache, lru_cache

from wmspec.compile.layout.geometry import volume
from wmspec.compile.layout.values import Values
from wmspec.compile.layout.view import front, seen
from wmspec.core.diagnostics import WmsError
from wmspec.lang.check.tables.colors import rgb
from wmspec.lang.check.tables.vocabulary import COLORS
from wmspec.runtime.questions.difference import ciede2000, lab
from wmspec.sim.materials import SHADES
from wmspec.sim.scene.model import Array

#: One object is larger than another if its edges are so many times as long; further aside by so much (m).
LARGER, ASIDE = 1.15, 0.03

#: Materials as adjectives, where their names are none.
_MADE = {"wood": "wooden", "stripes": "striped", "checker": "checkered"}


class Ambiguous(WmsError):
    """Two objects cannot be told apart in words."""


def described(name: str, values: Values) -> str:
    """An object in words that fit no other object that is there. Raises Ambiguous if there are no such words."""
    plain = _plain(name, values)
    rivals = [other for other in present(values) if other != name and _plain(other, values) == plain]
    if not rivals:
        return f"the {plain}"
    for ways in (_material, _size, _side, _depth):
        for words in ways(name, rivals, values):
            return f"the {words}"
    raise Ambiguous(f"`{name}` and `{rivals[0]}` are both {_article(plain)} and nothing tells them apart in words")


def present(values: Values) -> Iterator[str]:
    """The names of the objects that are there."""
    for thing in values.spec.things:
        if thing.kind == "object" and values.there(thing.name):
            yield thing.name


@lru_cache(maxsize=4096)
def color_word(color: str) -> str:
    """A colour as a person names it: its word, or that of the colour most like it."""
    if color in COLORS:
        return color
    if color in SHADES:
        return color.partition("_")[0]
    return min(_named(), key=lambda word: float(ciede2000(lab(rgb(color)), _named()[word])))


@cache
def _named() -> dict[str, Array]:
    """CIELAB of the colours that have names."""
    return {word: lab(color) for word, color in COLORS.items()}


def together(names: Sequence[str], values: Values) -> str | None:
    """Several members of a set, or things that are called alike, in words that fit them all and nothing else.

    By colour and noun if that is the same, else by noun; None if no such words fit them alone.
    """
    things = [values.spec.thing(name) for name in names]
    alike = len({thing.set or values.has(thing.name, "called") for thing in things}) == 1
    if len(names) < 2 or not alike or not (things[0].set or values.has(names[0], "called")):
        return None
    for words in (_plain, noun):
        first = words(names[0], values)
        fit = [other for other in present(values) if words(other, values) == first]
        if sorted(fit) == sorted(names):
            own = noun(names[0], values)
            return f"the {first.removesuffix(own)}{_plural(names[0], own, values)}"
    return None


def _plural(name: str, noun: str, values: Values) -> str:
    """What several are called: as the spec says, or by the rules of spelling."""
    if values.has(name, "plural"):
        return values.text(name, "plural")
    if noun.endswith(("s", "x", "ch", "sh")):
        return f"{noun}es"
    return f"{noun[:-1]}ies" if noun.endswith("y") and noun[-2:-1] not in "aeiou" else f"{noun}s"


def noun(name: str, values: Values) -> str:
    """What kind of thing an object is: what it is called, its shape, or its own name if it has parts or is a mesh."""
    if values.has(name, "called"):
        return values.text(name, "called")
    if values.parts(name) or values.has(name, "file") or not values.has(name, "shape"):
        return name.replace("_", " ")
    return values.text(name, "shape")


def _plain(name: str, values: Values) -> str:
    what = noun(name, values)
    formless = values.parts(name) or values.has(name, "file") or not values.has(name, "shape")
    if formless and not (values.has(name, "called") and values.has(name, "color")):
        return what
    return f"{color_word(values.text(name, 'color'))} {what}"


def _article(noun: str) -> str:
    return f"{'an' if noun[0] in 'aeio' else 'a'} {noun}"


# ---------------------------------------------------------------- what tells apart


def _material(name: str, rivals: list[str], values: Values) -> Iterator[str]:
    if not all(values.has(n, "material") for n in (name, *rivals)):
        return
    mine = values.text(name, "material")
    if all(values.text(other, "material") != mine for other in rivals):
        what = noun(name, values)
        yield f"{_plain(name, values).removesuffix(what)}{_MADE.get(mine, mine)} {what}"


def _size(name: str, rivals: list[str], values: Values) -> Iterator[str]:
    def edge(n: str) -> float:
        return float(volume(values, n) ** (1 / 3))

    words = ("larger", "smaller") if len(rivals) == 1 else ("largest", "smallest")
    for word in _extreme(edge(name), [edge(r) for r in rivals], words, lambda a, b: a > b * LARGER):
        yield f"{word} {_plain(name, values)}"


def _side(name: str, rivals: list[str], values: Values) -> Iterator[str]:
    yield from _placed(name, rivals, values, 0, ("on the right", "on the left"))


def _depth(name: str, rivals: list[str], values: Values) -> Iterator[str]:
    yield from _placed(name, rivals, values, 1, ("at the back", "at the front"))


def _placed(name: str, rivals: list[str], values: Values, axis: int, words: tuple[str, str]) -> Iterator[str]:
    way = front(values)
    here, *there = (seen(way, *values.pose(n).position[:2])[axis] for n in (name, *rivals))
    for word in _extreme(here, there, words, lambda a, b: a > b + ASIDE):
        yield f"{_plain(name, values)} {word}"


def _extreme(
    mine: float, others: list[float], words: tuple[str, str], beyond: Callable[[float, float], bool]
) -> Iterator[str]:
    if all(beyond(mine, other) for other in others):
        yield words[0]
    elif all(beyond(other, mine) for other in others):
        yield words[1]
