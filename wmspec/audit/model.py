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
    `p` the probability of a table so uneven by chance, by `method`; `corrected` is `p` after Holm, among all tests of
    the dataset that are `judged`.
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
    corrected: float = 1.0


@dataclass(frozen=True)
class Probe:
    """How often a small classifier that sees only `sees` picks the true option, on questions it was not fitted to.

    `right` of `asked` questions (ties count in part), `chance` is what guessing yields. (`low`, `high`) is the interval
    of its accuracy. One that is not `judged` sees what the question is meant to be answered from.
    """

    task: str
    sees: str
    asked: int
    right: float
    chance: float
    judged: bool
    why: str
    low: float = 0.0
    high: float = 1.0

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
class Audit:
    """Everything that was found in a dataset."""

    dataset: str
    findings: tuple[Finding, ...]
    counts: tuple[Counts, ...]
    tests: tuple[Test, ...]
    probes: tuple[Probe, ...]
    likeness: tuple[Likeness, ...]
    spreads: tuple[Spread, ...]
    about: dict[str, Any] = field(default_factory=dict)

    @property
    def passed(self) -> bool:
        """Whether nothing fails."""
        return not any(f.verdict == "fails" for f in self.findings)
