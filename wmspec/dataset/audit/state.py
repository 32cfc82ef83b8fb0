"""Where objects are in pictures and what they look like there, as numbers that a probe sees.

An object's numbers are those of a row's `context_objects` and `option_objects`: what a perfect eye would read off.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from wmspec.dataset.audit.cases import Case
from wmspec.dataset.build.rows import Row

Array = NDArray[np.float64]

#: What is read off an object: where it is in the picture and how large, how it is turned, its colour.
PLACES = ("across", "down", "share", "qw", "qx", "qy", "qz")
LOOKS = ("red", "green", "blue")
#: So many objects of a question are looked at: those that it is about come first.
MOST_OBJECTS = 6

#: The objects of one picture, by name.
Objects = Mapping[str, Row]


def pictured(case: Case, column: str) -> Sequence[Objects]:
    """The objects of each picture, of the context or of the options."""
    count = len(case.context) if column == "context_objects" else len(case.options)
    pictures: list[dict[str, Row]] = [{} for _ in range(count)]
    for seen in case.row.get(column) or ():
        pictures[seen["picture"]][seen["name"]] = seen
    return pictures


def known(cases: Sequence[Case]) -> bool:
    """Whether the rows say where objects are."""
    return all(case.row.get("context_objects") or case.row.get("option_objects") for case in cases)


def of_questions(cases: Sequence[Case], views: Sequence[int], about: bool = True) -> Array:
    """The objects of the pictures `views` and how they go from one to the next, a row for each question.

    By name; first those that it is `about`, and of these the ones that it speaks of most, since it asks of one of them.
    """
    rows = []
    for case in cases:
        pictures = pictured(case, "context_objects")
        names = _named(pictures, about, case.row["text"])
        seen = [[_numbers(pictures[view].get(name)) for name in names] for view in views]
        steps = [_step(a, b) for here, there in pairwise(seen) for a, b in zip(here, there, strict=True)]
        rows.append(np.concatenate([*(numbers for here in seen for numbers in here), *steps]))
    width = max(map(len, rows))
    return np.stack([np.pad(row, (0, width - len(row))) for row in rows])


def of_options(cases: Sequence[Case], views: Sequence[int]) -> Array:
    """The objects of each option picture, and how they differ from those of the pictures `views`: a row an option."""
    rows = []
    for case in cases:
        shown, offered = pictured(case, "context_objects"), pictured(case, "option_objects")
        names = _named([*shown, *offered], True)
        for objects in offered:
            here = [_numbers(objects.get(name)) for name in names]
            gaps = [h - _numbers(shown[v].get(name)) for v in views for h, name in zip(here, names, strict=True)]
            rows.append(np.concatenate([*here, *gaps, *map(abs, gaps)]))
    width = max(map(len, rows))
    return np.stack([np.pad(row, (0, width - len(row))) for row in rows])


def of_things(cases: Sequence[Case], views: Sequence[int]) -> Array:
    """The object that each option speaks of, in the pictures `views`: a row an option, nought if it is none."""
    rows = []
    for case in cases:
        pictures = pictured(case, "context_objects")
        for name in spoken_of(case):
            here = [_numbers(pictures[v].get(name)) if name else _numbers(None) for v in views]
            steps = [b - a for a, b in pairwise(here)]
            rows.append(np.concatenate([[float(name is not None)], *here, *steps, *map(abs, steps)]))
    return np.stack(rows)


def spoken_of(case: Case) -> list[str | None]:
    """The name of the one object that each option speaks of: by its own name, or by a word for its look."""
    looks = {seen["name"]: seen["look"].split() for seen in case.row.get("context_objects") or ()}
    names: list[str | None] = []
    for option in case.row["option_name"]:
        meant = [name for name, words in looks.items() if option == name or option in words]
        names.append(meant[0] if len(meant) == 1 else None)
    return names


def struck_out(cases: Sequence[Case]) -> list[NDArray[np.bool_]]:
    """Of each question, the options that whoever sees any picture strikes out.

    Of words, those that speak of what is not there. Of the pictures of a closed set, those that begin in another state:
    the state is there to be seen or told, and what follows from it is what the question is about.
    """
    return [_other_state(case) for case in cases] if cases[0].pictured else _unseen(cases)


def framed(cases: Sequence[Case]) -> bool:
    """Whether the options tell where all began: some differ from the truth in the action alone, and began there."""
    return any("action" in case.row["option_kind"] for case in cases)


def _other_state(case: Case) -> NDArray[np.bool_]:
    """The options that begin in another state, if there are others that differ in the action alone."""
    kinds = np.array(case.row["option_kind"])
    return np.isin(kinds, ("state", "both")) & bool((kinds == "action").any())


def _unseen(cases: Sequence[Case]) -> list[NDArray[np.bool_]]:
    """The options that speak of a look that nothing in the pictures has.

    Such as a colour that nothing has. A word such as "neither", which is no name and no look of anything in any of the
    questions, may always be true. Nothing is struck out if that could be the truth.
    """
    there = [_spoken(case) for case in cases]
    known = set().union(*there)
    struck = [
        np.array([o in known - words for o in c.row["option_name"]]) for c, words in zip(cases, there, strict=True)
    ]
    if any(gone[case.row["answer"]] for gone, case in zip(struck, cases, strict=True)):
        return [np.zeros(case.count, dtype=bool) for case in cases]
    return struck


def _spoken(case: Case) -> set[str]:
    """The names and the words for the looks of what is there."""
    return {w for seen in case.row.get("context_objects") or () for w in (seen["name"], *seen["look"].split())}


def _named(pictures: Sequence[Objects], about: bool, text: str = "") -> list[str]:
    """The names of the objects in order, so many of them as are looked at."""
    said = text.lower().replace("?", " ").replace(",", " ").replace(".", " ").split()
    asked: dict[str, tuple[bool, int]] = {}
    for picture in pictures:
        for name, seen in picture.items():
            asked[name] = not (about and seen["asked"]), -sum(said.count(word) for word in seen["look"].split())
    return sorted(asked, key=lambda name: (*asked[name], name))[:MOST_OBJECTS]


def _step(a: Array, b: Array) -> Array:
    """How far an object goes across, down, and in all."""
    across, down = (b - a)[:2]
    return np.array([across, down, np.hypot(across, down)])


def _numbers(seen: Row | None) -> Array:
    """What is read off an object; -1 where it is not seen."""
    if seen is None or not seen["share"]:
        return np.full(len(PLACES) + len(LOOKS), -1.0)
    return np.array([seen[name] for name in (*PLACES, *LOOKS)], dtype=np.float64)
