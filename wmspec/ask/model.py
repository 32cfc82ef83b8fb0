"""A question as it is put to a model or a person, or the reason why an instance yields none."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from wmspec.design.design import Setting


@dataclass(frozen=True)
class Picture:
    """What a camera saw at a time (s): `rgb` (h, w, 3) uint8."""

    camera: str
    time: float
    rgb: NDArray[np.uint8]


@dataclass(frozen=True)
class Change:
    """What a counterfactual changed: its kind (action, state, without), the value's name, what it was and became."""

    kind: str
    target: str
    before: str
    after: str


@dataclass(frozen=True)
class Option:
    """One option: its `text` (a label) or its `picture`.

    `kind` says what it is: the truth, a label that is not the answer, or a counterfactual with its name and change.
    """

    kind: Literal["truth", "label", "counterfactual"]
    name: str
    text: str | None = None
    picture: Picture | None = None
    change: Change | None = None


@dataclass(frozen=True)
class Asked:
    """A valid question.

    `task`, `index`, `question` and `engine` identify it; `answer` is the index of the true option and `value` the
    measured value in words. `groups` gives for every factor the key that all instances differing in it alone share.
    `margin` is how far the answer is from turning, as a multiple of the margin asked for (None without one).
    `measured` holds named quantities in SI units. `outcome` (n, 7) is the pose of every moving body in every option
    picture, (options, bodies, 7) for a picture question, and None for labels.
    """

    task: str
    dimension: str
    index: int
    block: int
    question: int
    seed: int
    engine: str
    renderer: str
    text: str
    context: tuple[Picture, ...]
    options: tuple[Option, ...]
    answer: int
    value: str
    factors: dict[str, Setting]
    nuisances: dict[str, Setting]
    groups: dict[str, str]
    margin: float | None
    measured: dict[str, float]
    outcome: NDArray[np.float64] | None = None
    agreement: tuple[tuple[str, int], ...] = ()


#: Why an instance yields no question. The word before a colon is what is counted.
Reason = Literal["ensure", "margin", "alike", "unseen", "disagreement", "invalid", "unstable", "crashed", "timeout"]


@dataclass(frozen=True)
class Rejected:
    """An instance that yields no question in an engine, and why."""

    task: str
    index: int
    question: int
    engine: str
    reason: Reason
    detail: str
