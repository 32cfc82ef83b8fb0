"""What an audit finds."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Literal

#: `fails` is a defect, `holds` its absence, `unclear` that there are too few questions to tell; `told` is for the
#: reader to judge, because it may be meant.
Verdict = Literal["fails", "unclear", "told", "holds"]


@dataclass(frozen=True)
class Finding:
    """One thing that was looked at: which check, of which task (or of the dataset, ""), and what was seen."""

    check: str
    task: str
    verdict: Verdict
    what: str


@dataclass(frozen=True)
class Test:
    """Whether two things are independent of each other, or one of them uniform (`second` is "").

    `counts` are the contingency table, a row for each value of `first`; `strength` is Cramér's V (or Cohen's w),
    `p` the probability of a table so uneven by chance, by `method`; `corrected` is `p` after Holm, among those of the
    task that are `judged` (`audit.balance.weighed`). `effect` is the design effect: so many questions are worth
    one, since those of a group are alike. `least` is the weakest dependence that would have been
    found in four of five datasets such as this.
    """

    task: str
    first: str
    second: str
    rows: tuple[str, ...]
    columns: tuple[str, ...]
    counts: tuple[tuple[int, ...], ...]
    strength: float
    p: float
    method: str
    judged: bool
    effect: float = 1.0
    corrected: float = 1.0
    least: float = 1.0


@dataclass(frozen=True)
class Probe:
    """How often a small classifier that sees only `sees` picks the true option, on questions it was not fitted to.

    `family` says what sort of thing it sees. `right` of `asked` questions (ties count in part), `chance` is what
    guessing yields, `deviation` the standard deviation of the accuracy about it. (`low`, `high`) is the 95 % interval
    of its accuracy; a judged one is `luck` if it is no further above chance than guessing gets. `least` is the smallest
    shortcut, in accuracy above chance, that would have been found in four of five datasets such as this; `learned` what
    the probe answered of shortcuts that were planted. One that is not `judged` sees what the question is meant to be
    answered from.
    """

    task: str
    sees: str
    family: str
    asked: int
    right: float
    chance: float
    deviation: float
    judged: bool
    why: str
    learned: tuple[float, ...] | None = None
    low: float = 0.0
    high: float = 1.0
    least: float = 1.0
    luck: bool = True

    @property
    def accuracy(self) -> float:
        """The share of questions that it answers."""
        return self.right / self.asked if self.asked else 0.0


@dataclass(frozen=True)
class Counts:
    """How many of a task's questions there are: asked, kept, and rejected by reason; instances planned."""

    task: str
    dimension: str
    instances: int
    asked: int
    kept: int
    rejected: dict[str, int]


@dataclass(frozen=True)
class Likeness:
    """How alike the options of a task's questions are: the share of pixels in which the closest two differ.

    `quantiles` are the least, the quarter, the median, the three quarters and the most; `pairs` the median for every
    pair of options by name; `closest` the question whose options are most alike.
    """

    task: str
    quantiles: tuple[float, ...]
    pairs: dict[str, float]
    closest: str


@dataclass(frozen=True)
class Spread:
    """How a quantity, such as the stimulus difference, is spread over a task's questions."""

    task: str
    name: str
    unit: str
    quantiles: tuple[float, ...]


@dataclass(frozen=True)
class Summary:
    """What there is to say of a task in one line: whether it passes, why not, and how much was looked at.

    `verdict` is `unclear` where nothing fails and something cannot be told. `groups` are the independent control
    groups that its questions come from: the effective sample size. Of the judged probes: the most that any answers
    `above` chance, which one that is, and the `least` shortcut that all of them would have found. They are None if
    nothing was probed. `stable` is the share of answers that hold (`wmspec.dataset.audit.stability`), None if unknown.
    """

    task: str
    verdict: Literal["fails", "unclear", "holds"]
    why: tuple[str, ...]
    questions: int
    groups: int
    above: float | None
    best: str
    least: float | None
    stable: float | None


@dataclass(frozen=True)
class Audit:
    """Everything that was found in a dataset."""

    dataset: str
    findings: tuple[Finding, ...]
    counts: tuple[Counts, ...]
    tests: tuple[Test, ...]
    probes: tuple[Probe, ...]
    likeness: tuple[Likeness, ...]
    spreads: tuple[Spread, ...]
    summaries: tuple[Summary, ...]
    about: dict[str, Any] = field(default_factory=dict)

    @property
    def passed(self) -> bool:
        """Whether nothing fails."""
        return not any(f.verdict == "fails" for f in self.findings)
