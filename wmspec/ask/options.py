"""The options of a question: labels, or the pictures of what would have been."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Any

import numpy as np
from numpy.typing import NDArray

from wmspec.ask.model import Change, Option, Picture, Reject
from wmspec.ask.runs import Run
from wmspec.ask.verbalize import say, say_option
from wmspec.check.evaluate import evaluate
from wmspec.check.ir import Counterfactual, Question
from wmspec.draws import bits
from wmspec.layout.values import Values
from wmspec.scene.model import Frame

#: Two option pictures in which fewer pixels than this show something different look alike.
LEAST_DIFFERENT = 100 / 256**2


@dataclass(frozen=True)
class AnswerSlot:
    """Where the truth goes: at `position` modulo the number of options; `key` decides the order of the others."""

    position: int
    key: tuple[object, ...]

    def order(self, truth: int, n: int) -> list[int]:
        """The options 0..n-1 in order, the truth at its place."""
        others = sorted((i for i in range(n) if i != truth), key=lambda i: bits(*self.key, i))
        others.insert(self.position % n, truth)
        return others


def labelled(question: Question, answer: Any, values: Values, seat: AnswerSlot) -> tuple[tuple[Option, ...], int]:
    """The options in words and the place of the true one; truth values have `yes` and `no`.

    Raises Reject if the answer is none of them, or if two read the same.
    """
    choices = list(evaluate(question.options, values)) if question.options is not None else [True, False]
    truth = [i for i, choice in enumerate(choices) if same(choice, answer)]
    texts = [say_option(c, question.sort, values) for c in choices]
    if not truth:
        raise Reject("invalid", f"the answer {say(answer, question.sort, values)} is not among the options")
    if len(set(texts)) < len(texts):
        raise Reject("alike", f"two options read the same: {', '.join(texts)}")
    order = seat.order(truth[0], len(choices))
    options = [Option("truth" if i == truth[0] else "label", _name(choices[i]), text=texts[i]) for i in order]
    return tuple(options), order.index(truth[0])


def same(a: Any, b: Any) -> bool:
    """Whether two values are one answer; numbers that differ by rounding alone are, and directions by whole turns."""
    if isinstance(a, float) and isinstance(b, float):
        return abs(a - b) <= 1e-12 + 1e-9 * abs(b)
    return bool(a == b)


def _name(choice: Any) -> str:
    return (
        f"{choice:g}" if isinstance(choice, float) else str(choice).lower() if choice in (True, False) else str(choice)
    )


@dataclass(frozen=True)
class Alternative:
    """One option of a picture question: the run, the counterfactual that it is (None: the truth), its picture."""

    run: Run
    change: Counterfactual | None
    frame: Frame

    @property
    def name(self) -> str:
        """The counterfactual's name, or `truth`."""
        return self.change.name if self.change is not None else "truth"


def pictured(
    alternatives: Sequence[Alternative], camera: str, time: float, seat: AnswerSlot
) -> tuple[tuple[Option, ...], list[int]]:
    """The alternatives, the truth being the first, as options, and the order in which they are given.

    Raises Reject if two look alike.
    """
    for a, b in combinations(alternatives, 2):
        if (share := differing(a, b)) < LEAST_DIFFERENT:
            raise Reject("alike", f"{a.name} and {b.name}: {share:.3%} of the picture differs")
    order = seat.order(0, len(alternatives))
    options = []
    for alternative in (alternatives[i] for i in order):
        picture = Picture(camera, time, alternative.frame.rgb)
        change = alternative.change
        said = told(change, alternatives[0].run.values, alternative.run.values) if change is not None else None
        kind: Any = "truth" if change is None else "counterfactual"
        options.append(Option(kind, alternative.name, picture=picture, change=said))
    return tuple(options), order


def differing(a: Alternative, b: Alternative) -> float:
    """The share of two pictures that shows different bodies, or bodies that look different."""
    looks: dict[tuple[str, tuple[object, ...]], int] = {}
    return float((_known(a, looks) != _known(b, looks)).mean())


def _known(a: Alternative, looks: dict[tuple[str, tuple[object, ...]], int]) -> NDArray[np.int64]:
    """The picture with a number for every body and its surfaces, the same in all pictures."""
    bodies = [(b.name, tuple(g.surface for g in b.geoms if g.visible)) for b in a.run.scene.bodies]
    table = np.array([looks.setdefault(body, len(looks)) for body in bodies] + [-1])
    return np.asarray(table[a.frame.ids])


def told(change: Counterfactual, before: Values, after: Values) -> Change:
    """What a counterfactual changed, in words."""
    if change.change == "without":
        return Change("without", change.owner, "done", "left out")
    if change.change == "order":
        starts = {name: before.property(name, "start") for name in (change.owner, change.property)}
        first, second = sorted(starts, key=lambda name: starts[name])
        return Change("order", f"{first}, {second}", f"{first} first", f"{second} first")
    owner, name = change.owner, change.property
    was = say(before.property(owner, name), change.sort, before) if before.has(owner, name) else "unset"
    return Change(change.change, f"{owner}.{name}", was, say(after.property(owner, name), change.sort, after))
