"""The objects and properties that the options of a question name: object, colour, shape or side."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence

from wmspec.dataset.build.rows import Row
from wmspec.lang.check.tables.vocabulary import WORDS

#: Dimensions of properties, and the words of their levels.
_LEVELS: dict[str, frozenset[str]] = {name: frozenset(WORDS[name]) for name in ("color", "shape", "material")} | {
    "position": frozenset([
        "left", "right", "up", "down", "front", "back", "upper", "lower", "top", "bottom", "near", "far", "above",
        "below", "behind", "before"
    ])
}  # fmt: skip
_WORD = re.compile(r"[a-z]+")
_NUMBER = re.compile(r"_\d+$")
#: Least distance (m) by which an object has moved between two images.
_MOVED = 0.01


def object_named(words: str, objects: Sequence[Row]) -> str:
    """Return the name of the only object that words such as "the red cube" refer to; '' if there is none.

    `objects` are those of a picture, each with `name` and `look`, such as "red cube wood". If the question names some
    of them, words refer to those. "more red apples" refers to the members of one group of objects, by its name. Words
    of a property alone ("red") name no object.
    """
    tokens = _WORD.findall(words.casefold())
    colors = _LEVELS["color"] & set(tokens)
    if len(colors) != 1 or not set(tokens) - colors - {"the", "a", "an"}:
        return ""
    (color,) = colors
    colored = [row for row in objects if color in (row["look"] or "").split()]
    found = {row["name"] for row in [row for row in colored if row["asked"]] or colored}
    if len(found) > 1:
        found = {_group(name) for name in found}
    return found.pop() if len(found) == 1 else ""


def _group(name: str) -> str:
    """Return the name of the group of a member such as `tiles_2`; that of a single object is its own."""
    return _NUMBER.sub("", name)


def properties(words: str | None, change: str | None) -> dict[str, str]:
    """Return the levels that an option has, by dimension, from its words or from what its counterfactual changes.

    A change such as "action pace: fast -> slow" has the level "slow" of "pace".
    """
    if words is not None:
        tokens = set(_WORD.findall(words.casefold()))
        found = {name: levels & tokens for name, levels in _LEVELS.items()}
        return {name: next(iter(levels)) for name, levels in found.items() if len(levels) == 1}
    parts = (part.partition(": ") for part in (change or "").split("; ") if " -> " in part)
    return {head.split(" ", 1)[-1]: change.rpartition(" -> ")[2] for head, _, change in parts}


def true_properties(changes: Sequence[str | None]) -> dict[str, str]:
    """Return the levels of the true picture: what the changes of the others change from."""
    parts = [part.partition(": ") for change in changes for part in (change or "").split("; ") if " -> " in part]
    return {head.split(" ", 1)[-1]: change.partition(" -> ")[0] for head, _, change in parts}


def look_of(row: Row) -> dict[str, str]:
    """Return color, shape and material of the object that a question is about, as shown; empty if it is none or
    several.

    It is the object that the true option names, else the only one that the question names, else the only one of these
    (or of all, if it names none) that moves. Members of one group count as one object, with what they have in common.
    """
    shown = list(row.get("context_objects") or ())
    objects = [o for o in shown if o["picture"] == 0]
    words = row["option_text"]
    name = object_named(words[row["answer"]], objects) if words and row["answer"] is not None else ""
    if name:
        about = [o for o in objects if name in (o["name"], _group(o["name"]))]
    else:
        about = [o for o in objects if o["asked"]]
        if len({_group(o["name"]) for o in about}) != 1:
            moving = _moving(shown)
            about = [o for o in about or objects if o["name"] in moving]
    if len({_group(o["name"]) for o in about}) != 1:
        return {}
    tokens = set.intersection(*(set((o["look"] or "").split()) for o in about))
    found = {kind: _LEVELS[kind] & tokens for kind in ("color", "shape", "material")}
    return {kind: next(iter(levels)) for kind, levels in found.items() if len(levels) == 1}


def _moving(shown: Sequence[Row]) -> set[str]:
    """Return the names of the objects that are elsewhere in another image than in the first one that has them."""
    first: dict[str, tuple[float, ...]] = {}
    moving = set()
    for each in shown:
        here = tuple(each[axis] for axis in "xyz")
        if math.dist(here, first.setdefault(each["name"], here)) > _MOVED:
            moving.add(each["name"])
    return moving
