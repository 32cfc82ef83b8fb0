"""Positions and appearance of objects in pictures, as features for probes.

The values come from `context_objects` and `option_objects`: the state that perfect vision would extract.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from wmspec.dataset.audit.cases import Case
from wmspec.dataset.build.rows import Row
from wmspec.dataset.film.distances import Array

#: Features of an object: position and area in the picture, orientation, colour.
POSE_CHANNELS = ("across", "down", "share", "qw", "qx", "qy", "qz")
COLOUR_CHANNELS = ("red", "green", "blue")
#: Decimals of a feature that a picture can show: half a pixel, a pixel of area, one degree, 2 of 255 shades. What is
#: finer, such as how a body trembles at rest, is no evidence for anyone who sees the picture.
DECIMALS = (
    dict.fromkeys(("across", "down"), 3) | {"share": 5} | dict.fromkeys((*POSE_CHANNELS[3:], *COLOUR_CHANNELS), 2)
)
#: The material without a pattern, and shapes that then look alike however they are turned about their axis.
PLAIN, ROUND = "plastic", frozenset(("cylinder", "cone", "capsule", "tube"))
#: The orientation that stands for all.
UPRIGHT = {"qw": 1.0, "qx": 0.0, "qy": 0.0, "qz": 0.0}
#: Maximum number of objects of a question; those that it is about come first.
MAX_OBJECTS = 6

#: The objects of one picture, by name.
Objects = Mapping[str, Row]


def objects_by_picture(case: Case, column: str) -> Sequence[Objects]:
    """Return the objects of each picture, of the context or of the options."""
    count = len(case.context) if column == "context_objects" else len(case.options)
    pictures: list[dict[str, Row]] = [{} for _ in range(count)]
    for seen in case.row.get(column) or ():
        pictures[seen["picture"]][seen["name"]] = seen
    return pictures


def has_object_states(cases: Sequence[Case]) -> bool:
    """Whether the rows have object states."""
    return all(case.row.get("context_objects") or case.row.get("option_objects") for case in cases)


def question_states(cases: Sequence[Case], views: Sequence[int]) -> Array:
    """Return the objects of the pictures `views` and their motion between pictures, one row a question.

    Objects of the question come first, and those mentioned most often before others; then they are ordered by name.
    """
    rows = []
    for case in cases:
        pictures = objects_by_picture(case, "context_objects")
        names = _named(pictures, case.row["text"])
        seen = [[_numbers(pictures[view].get(name)) for name in names] for view in views]
        steps = [_step(a, b) for here, there in pairwise(seen) for a, b in zip(here, there, strict=True)]
        rows.append(np.concatenate([*(numbers for here in seen for numbers in here), *steps]))
    width = max(map(len, rows))
    return np.stack([np.pad(row, (0, width - len(row))) for row in rows])


def option_states(cases: Sequence[Case], views: Sequence[int]) -> Array:
    """Return the objects of each option picture, and their differences to the pictures `views`: one row an option."""
    rows = []
    for case in cases:
        shown, offered = objects_by_picture(case, "context_objects"), objects_by_picture(case, "option_objects")
        names = _named([*shown, *offered])
        for objects in offered:
            here = [_numbers(objects.get(name)) for name in names]
            gaps = [h - _numbers(shown[v].get(name)) for v in views for h, name in zip(here, names, strict=True)]
            rows.append(np.concatenate([*here, *gaps, *map(abs, gaps)]))
    width = max(map(len, rows))
    return np.stack([np.pad(row, (0, width - len(row))) for row in rows])


def named_object_states(cases: Sequence[Case], views: Sequence[int]) -> Array:
    """Return the object that each option names, in the pictures `views`: one row an option, zeros if none."""
    rows = []
    for case in cases:
        pictures = objects_by_picture(case, "context_objects")
        for name in named_objects(case):
            here = [_numbers(pictures[v].get(name)) if name else _numbers(None) for v in views]
            steps = [b - a for a, b in pairwise(here)]
            rows.append(np.concatenate([[float(name is not None)], *here, *steps, *map(abs, steps)]))
    return np.stack(rows)


def named_objects(case: Case) -> list[str | None]:
    """Return the name of the one object that each option refers to, by its name or by a word for its look."""
    looks = {seen["name"]: seen["look"].split() for seen in case.row.get("context_objects") or ()}
    names: list[str | None] = []
    for option in case.row["option_name"]:
        matches = [name for name, words in looks.items() if option == name or option in words]
        names.append(matches[0] if len(matches) == 1 else None)
    return names


def eliminated_options(cases: Sequence[Case]) -> list[NDArray[np.bool_]]:
    """Return, for each question, the options that any view of the scene eliminates.

    Words that refer to absent objects are eliminated. In a closed set of pictures, options that begin in another state
    are eliminated: the state is visible or given, and the question is about its consequences.
    """
    return [_other_state(case) for case in cases] if cases[0].has_picture_options else _absent_looks(cases)


def reveals_initial_state(cases: Sequence[Case]) -> bool:
    """Whether the options reveal the initial state.

    They do if some differ from the truth in the action alone and so begin in the same state.
    """
    return any("action" in case.row["option_kind"] for case in cases)


def _other_state(case: Case) -> NDArray[np.bool_]:
    """Return the options that begin in another state, if others differ in the action alone."""
    kinds = np.array(case.row["option_kind"])
    return np.isin(kinds, ("state", "both")) & bool((kinds == "action").any())


def _absent_looks(cases: Sequence[Case]) -> list[NDArray[np.bool_]]:
    """Return the options that refer to a look that no visible object has, such as an absent colour.

    A word such as "neither", which is no name or look in any of the questions, may always be true. Nothing is
    eliminated if that could be the truth.
    """
    there = [_present_words(case) for case in cases]
    known = set().union(*there)
    struck = [
        np.array([o in known - words for o in c.row["option_name"]]) for c, words in zip(cases, there, strict=True)
    ]
    if any(gone[case.row["answer"]] for gone, case in zip(struck, cases, strict=True)):
        return [np.zeros(case.count, dtype=bool) for case in cases]
    return struck


def _present_words(case: Case) -> set[str]:
    """Return the names of present objects and the words for their looks."""
    return {w for seen in case.row.get("context_objects") or () for w in (seen["name"], *seen["look"].split())}


def _named(pictures: Sequence[Objects], text: str = "") -> list[str]:
    """Return the names of the objects in order, at most MOST_OBJECTS."""
    said = text.lower().replace("?", " ").replace(",", " ").replace(".", " ").split()
    sort_keys: dict[str, tuple[bool, int]] = {}
    for picture in pictures:
        for name, seen in picture.items():
            sort_keys[name] = not seen["asked"], -sum(said.count(word) for word in seen["look"].split())
    return sorted(sort_keys, key=lambda name: (*sort_keys[name], name))[:MAX_OBJECTS]


def _step(a: Array, b: Array) -> Array:
    """Return the displacement of an object: horizontal, vertical and total."""
    across, down = (b - a)[:2]
    return np.array([across, down, np.hypot(across, down)])


def _numbers(seen: Row | None) -> Array:
    """Return the features of an object, no finer than a picture shows them; -1 where it is not visible."""
    if seen is None or not seen["share"]:
        return np.full(len(POSE_CHANNELS) + len(COLOUR_CHANNELS), -1.0)
    shown = {**seen, **_seen_turn(seen)}
    return np.array([round(shown[name], DECIMALS[name]) for name in (*POSE_CHANNELS, *COLOUR_CHANNELS)])


def _seen_turn(seen: Row) -> dict[str, float]:
    """Return the orientation of an object as far as a picture shows it, with a positive first component.

    A quaternion and its negative are the same orientation. A simulation continues the sign of the moment before, so the
    sign would reveal what has turned.
    """
    words = seen["look"].split()
    sign = -1.0 if next((seen[name] for name in UPRIGHT if seen[name]), 1.0) < 0 else 1.0
    w, x, y, z = (sign * float(seen[name]) for name in UPRIGHT)
    turn = {"qw": w, "qx": x, "qy": y, "qz": z}
    if PLAIN not in words:
        return turn
    if "sphere" in words:
        return UPRIGHT
    length = float(np.hypot(w, z))
    if not length or ROUND.isdisjoint(words):
        return turn
    # Without the turn about its axis.
    return {"qw": length, "qx": (x * w - y * z) / length, "qy": (y * w + x * z) / length, "qz": 0.0}
