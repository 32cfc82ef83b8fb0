"""Questions for models and people, and rejections."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, ClassVar, Final, Literal

import numpy as np
from numpy.typing import NDArray

from wmspec.compile.design.levels import Level
from wmspec.lang.check.ir.ir import QuestionKind

#: The name of the true run and of its option.
TRUTH = "truth"


@dataclass(frozen=True)
class Picture:
    """A picture of a camera at a time (s): `rgb` (h, w, 3) uint8.

    If requested: `depth` (h, w) float32, m along the view axis, 0 for background; `ids` (h, w) int16, indices into
    `names`, -1 for background.
    """

    camera: str
    time: float
    rgb: NDArray[np.uint8]
    depth: NDArray[np.float32] | None = None
    ids: NDArray[np.int16] | None = None
    names: tuple[str, ...] = ()


@dataclass(frozen=True)
class VisibleObject:
    """An object in a picture: name, words for its appearance, and whether the question is about it (`queried`).

    `position` (m) is its centre in the world, `orientation` (w, x, y, z). `share` is its share of the picture, `across`
    and `down` its centre from left and top (0 to 1), `color` its mean sRGB (0 to 1); None if it is not visible.
    """

    name: str
    words: tuple[str, ...]
    queried: bool
    position: tuple[float, ...]
    orientation: tuple[float, ...]
    share: float
    across: float | None
    down: float | None
    color: tuple[float, ...] | None


@dataclass(frozen=True)
class VisiblePart:
    """The `share` (0 to 1) of an object that a picture shows: 1 if nothing hides it, 0 if it is hidden or gone."""

    picture: int
    name: str
    share: float


@dataclass(frozen=True)
class Change:
    """The change of a counterfactual: kind (see `lang.check.ir.ir.Change`), target, value before and after.

    In a closed set several factors may differ: `beside` holds the next change.
    """

    kind: str
    target: str
    before: str
    after: str
    beside: Change | None = None


#: The kind of an option: the truth, a wrong label, a counterfactual; in a closed set, whether state, action or both
#: differ from the truth; of a what-if, what happens without its change.
OptionKind = Literal["truth", "label", "counterfactual", "state", "action", "both", "actual"]


#: Kinds of options that show what does not happen.
HYPOTHETICAL: frozenset[OptionKind] = frozenset(("counterfactual", "state", "action", "both"))


@dataclass(frozen=True)
class Option:
    """One option: its `text` (a label) or its `picture`.

    A counterfactual has the name of its counterfactual and its `change`. `outcome` is the kind of its outcome, if the
    question defines kinds, and `objects` are its visible objects.
    """

    kind: OptionKind
    name: str
    text: str | None = None
    picture: Picture | None = None
    change: Change | None = None
    outcome: str | None = None
    objects: tuple[VisibleObject, ...] = ()


@dataclass(frozen=True)
class Strength:
    """The strength of the stimulus: quantity as written, SI unit, value."""

    quantity: str
    unit: str
    value: float


@dataclass(frozen=True)
class Legibility:
    """How clearly a person sees what decides the answer: measure, unit, value, and the bound that it must meet.

    `runtime.questions.legibility.bounds` has all measures. `of` is the object with this value, if it is of one.
    """

    name: str
    unit: str
    value: float
    bound: float
    of: str = ""


@dataclass(frozen=True)
class Number:
    """A numeric answer: value, SI unit, and the tolerance of an open question."""

    value: float
    unit: str
    within: float | None = None


@dataclass(frozen=True)
class Vote:
    """The answer of an engine.

    `answer` is the selected option (None if there is none), `value` the answer in words, `rejected` the reason of a
    rejection. `apart` is the largest distance (m) of a body from its place in the engine of the row (None if one of the
    two did not execute the episode).
    """

    engine: str
    answer: int | None
    value: str
    rejected: str | None = None
    apart: float | None = None


@dataclass(frozen=True)
class Answer:
    """The answer of an engine with everything needed for comparison. Each kind of question has a subclass.

    `actual` is the value of a what-if's expression in the true episode, None if it has none there or is no what-if, and
    `actual_words` its wording.
    """

    kind: ClassVar[QuestionKind]
    actual: Any = field(default=None, kw_only=True)
    actual_words: str | None = field(default=None, kw_only=True)


@dataclass(frozen=True)
class Measurement:
    """The answer of an engine without pictures: what is compared with other engines, and the answer in words."""

    evidence: Answer
    value: str


@dataclass(frozen=True)
class QuestionRow:
    """A valid question.

    `task`, `index`, `question` and `engine` identify it, `name` is its own name if any. `answer` is the index of the
    true option (None for open questions), `value` the measured value in words, `number` the value if it is a number.
    `groups` gives, for every factor, the key shared by instances that differ in it only. `margin` is the distance from
    a change of the answer relative to the required margin (None without one). `sorted_outcomes`: a question of the task
    defines kinds of outcome. `levels` are the named values of factors and nuisances in words. `measured` holds named
    quantities in SI units. A `standing` answer holds from the start, and `moments` is the number of moments that show
    it. `objects` are those of every shown picture, `crossed` the factors that vary within the group. `redrawn` counts
    earlier draws of a balanced group (None: not balanced). `legibility` are all applicable measures. `label` is
    the answer as it is counted (see `answer_label`). `visible` has the visible share, in every shown picture, of
    objects that may be hidden (None: no question of the task allows it). `what_ifs` are the changes that the question
    imagines (None: no question of the task imagines any), and `actual` is the value of its expression without them, in
    words. `evidence` is compared with other engines. `film_text` and `action_text` describe film and action for video
    models; empty if the spec has none.
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
    answer: int | None
    value: str
    factors: dict[str, Level]
    nuisances: dict[str, Level]
    groups: dict[str, str]
    margin: float | None
    measured: dict[str, float]
    evidence: Answer
    agreement: tuple[Vote, ...] = ()
    name: str = ""
    number: Number | None = None
    difference: Strength | None = None
    standing: bool = False
    levels: dict[str, str] = field(default_factory=dict)
    sorted_outcomes: bool = False
    moments: int = 1
    objects: tuple[tuple[VisibleObject, ...], ...] = ()
    crossed: tuple[str, ...] = ()
    redrawn: int | None = None
    legibility: tuple[Legibility, ...] = ()
    label: str = ""
    visible: tuple[VisiblePart, ...] | None = None
    what_ifs: tuple[Change, ...] | None = None
    actual: str | None = None
    film_text: str = ""
    action_text: str = ""

    @property
    def kind(self) -> QuestionKind:
        """The kind of the question."""
        return self.evidence.kind


#: Reasons of rejections. The word before a colon is counted.
Reason = Literal[
    "ensure", "margin", "alike", "unseen", "illegible", "overlap", "unstable", "disagreement", "invalid", "error",
    "group", "balance", "cause", "unchanged", "crashed", "timeout",
]  # fmt: skip

#: Reasons that depend on the machine: the instance may succeed another time.
TRANSIENT: Final = frozenset[Reason](("crashed", "timeout"))

#: Reasons that no gate gives: the making itself failed.
FAILED: Final = frozenset[Reason](("error", *TRANSIENT))


@dataclass(frozen=True)
class Rejected:
    """An instance without a question in an engine, and the reason.

    `answer` is the answer as it is counted (see `answer_label`), if it is known and has words.
    """

    task: str
    index: int
    question: int
    engine: str
    reason: Reason
    detail: str
    answer: str = ""


class Reject(Exception):
    """Raised when an instance yields no question."""

    def __init__(self, reason: Reason, detail: str) -> None:
        super().__init__(detail)
        self.reason: Reason = reason
        self.detail = detail
