"""A question as it is put to a model or a person, or the reason why an instance yields none."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import ClassVar, Final, Literal

import numpy as np
from numpy.typing import NDArray

from wmspec.compile.design.levels import Level
from wmspec.lang.check.ir.ir import QuestionKind

#: What happens, among what would have happened: the name of its run and of its option.
TRUTH = "truth"


@dataclass(frozen=True)
class Picture:
    """What a camera saw at a time (s): `rgb` (h, w, 3) uint8.

    Where the spec asks for them: `depth` (h, w) float32, metres along the view axis, 0 for nothing; `ids` (h, w) int16,
    which of the bodies `names` is seen, -1 for none.
    """

    camera: str
    time: float
    rgb: NDArray[np.uint8]
    depth: NDArray[np.float32] | None = None
    ids: NDArray[np.int16] | None = None
    names: tuple[str, ...] = ()


@dataclass(frozen=True)
class Sighting:
    """An object in a picture: its name, the words for its look, and whether the question is about it.

    `position` (m) is its middle in the world, `orientation` (w, x, y, z) how it is turned. `share` of the picture shows
    it, about (`across`, `down`), each 0 to 1 from the left and from the top, in a mean sRGB `color` of 0 to 1; None if
    nothing of it is seen.
    """

    name: str
    words: tuple[str, ...]
    asked: bool
    position: tuple[float, ...]
    orientation: tuple[float, ...]
    share: float
    across: float | None
    down: float | None
    color: tuple[float, ...] | None


@dataclass(frozen=True)
class Change:
    """What a counterfactual changed: its kind (see `lang.check.ir.ir.Change`), what, what it was and became.

    In a closed set of options several factors may differ: `beside` it is what else does.
    """

    kind: str
    target: str
    before: str
    after: str
    beside: Change | None = None


#: What an option is: the truth, a label that is not the answer, a counterfactual; or, of a closed set, in what it
#: differs from the truth: in the state before anything happens, in what is done, or in both.
OptionKind = Literal["truth", "label", "counterfactual", "state", "action", "both"]


#: What an option is that shows what does not happen.
FORESEEN: frozenset[OptionKind] = frozenset(("counterfactual", "state", "action", "both"))


@dataclass(frozen=True)
class Option:
    """One option: its `text` (a label) or its `picture`.

    What would have happened has the name of its counterfactual and its `change`. `outcome` is the kind of what the
    picture shows, if the question says which there are, and `objects` what of it is to be seen.
    """

    kind: OptionKind
    name: str
    text: str | None = None
    picture: Picture | None = None
    change: Change | None = None
    outcome: str | None = None
    objects: tuple[Sighting, ...] = ()


@dataclass(frozen=True)
class Strength:
    """How strong the stimulus is: the quantity as it is written, its SI unit, its value."""

    quantity: str
    unit: str
    value: float


@dataclass(frozen=True)
class Number:
    """An answer that is a number: its value and SI unit, and, of an open question, how far off is still right."""

    value: float
    unit: str
    within: float | None = None


@dataclass(frozen=True)
class Vote:
    """What an engine says.

    The option that its outcome picks (None: it picks none, or there are none), the answer in words, and why it would
    not ask (None if it would).
    """

    engine: str
    answer: int | None
    value: str
    rejected: str | None = None


@dataclass(frozen=True)
class Answer:
    """What an engine answers, with all that answers are compared by. Each kind of question has its own."""

    kind: ClassVar[QuestionKind]


@dataclass(frozen=True)
class QuestionRow:
    """A valid question.

    `task`, `index`, `question` and `engine` identify it, `name` is the question's own if it has one. `answer` is the
    index of the true option (None for an open question, which has no options) and `value` the measured value in words,
    `number` as a number if it is one. `groups` gives for every factor the key that all instances differing in it alone
    share. `margin` is how far the answer is from turning, as a multiple of the margin asked for (None without one).
    `sorted_outcomes` says that a question of the task names kinds of outcome. `levels` are the values, in words, of
    those factors and nuisances whose values have names.
    `measured` holds named quantities in SI units; an answer is `standing` if it holds from the start, whatever happens,
    and `moments` is how many moments of the episode it takes to see it. `objects` are those of every picture shown,
    `crossed` the factors that vary within the block.
    `redrawn` is how often what the group draws was drawn otherwise before, where answers are balanced (None: they are
    not). `evidence` is what the answer is compared by with those of other engines.
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
    objects: tuple[tuple[Sighting, ...], ...] = ()
    crossed: tuple[str, ...] = ()
    redrawn: int | None = None

    @property
    def kind(self) -> QuestionKind:
        """The kind of the question."""
        return self.evidence.kind


#: Why an instance yields no question. The word before a colon is what is counted.
Reason = Literal[
    "ensure", "margin", "alike", "unseen", "overlap", "unstable", "disagreement", "invalid", "error", "group",
    "balance", "crashed", "timeout",
]  # fmt: skip

#: Reasons that lie with the machine and with what else it did: another time the instance may yield its questions.
PASSING: Final = frozenset[Reason](("crashed", "timeout"))

#: Reasons that no gate gives: the making itself failed.
FAILED: Final = frozenset[Reason](("error", *PASSING))


@dataclass(frozen=True)
class Rejected:
    """An instance that yields no question in an engine, and why."""

    task: str
    index: int
    question: int
    engine: str
    reason: Reason
    detail: str


class Reject(Exception):
    """Why an instance yields no question."""

    def __init__(self, reason: Reason, detail: str) -> None:
        super().__init__(detail)
        self.reason: Reason = reason
        self.detail = detail
