"""The objects and properties that the options of a question name: object, colour, shape or side."""

from __future__ import annotations

import re
from collections.abc import Sequence

from wmspec.dataset.build.rows import Row
from wmspec.lang.check.tables.vocabulary import WORDS

#: Dimensions of properties, and the words of their levels.
_LEVELS: dict[str, frozenset[str]] = {name: frozenset(WORDS[name]) for name in ("color", "shape", "material")} | {
    "position": frozenset(
        [
            "left",
            "right",
            "up",
            "down",
            "front",
            "back",
            "upper",
            "lower",
            "top",
            "bottom",
            "near",
            "far",
            "above",
            "below",
            "behind",
            "before",
        ]
    )
}
_WORD = re.compile(r"[a-z]+")
#: Words that name an object by its property alone: "the red one".
_PRONOUNS = frozenset({"one", "object", "thing"})


def object_named(words: str, objects: Sequence[Row]) -> str:
    """Return the name of the only object that words such as "the red cube" refer to; '' if there is none.

    `objects` are those of a picture, each with `name` and `look`, such as "red cube wood". Words of a property alone
    ("red") name no object.
    """
    tokens = _WORD.findall(words.casefold())
    colors = _LEVELS["color"] & set(tokens)
    if len(colors) != 1 or not set(tokens) - colors - {"the", "a", "an"}:
        return ""
    (color,) = colors
    found = {row["name"] for row in objects if color in (row["look"] or "").split()}
    return found.pop() if len(found) == 1 else ""


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

    It is the object that the true option names, else the only one that the question names.
    """
    objects = [o for o in row.get("context_objects") or () if o["picture"] == 0]
    words = row["option_text"]
    name = object_named(words[row["answer"]], objects) if words and row["answer"] is not None else ""
    about = [o for o in objects if o["name"] == name] if name else [o for o in objects if o["asked"]]
    if len(about) != 1:
        return {}
    tokens = set((about[0]["look"] or "").split())
    found = {kind: _LEVELS[kind] & tokens for kind in ("color", "shape", "material")}
    return {kind: next(iter(levels)) for kind, levels in found.items() if len(levels) == 1}
