"""The results of an audit."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Literal

#: Version of audit.json. Version 1, without the field `format`, had another name for the verdict `reported`.
FORMAT = 2

#: `fails` is a defect, `holds` its absence, `unclear` lack of data. `reported` results are not judged, because they may
#: be intended.
Verdict = Literal["fails", "unclear", "reported", "holds"]


@dataclass(frozen=True)
class Finding:
    """One result: the check, the task ('' for the dataset), the verdict, and a description."""

    check: str
    task: str
    verdict: Verdict
    what: str


@dataclass(frozen=True)
class Test:
    """A test of independence of two variables, or of uniformity of one (`second` is '').

    `counts` is the contingency table, with a row for each value of `first`. `strength` is Cramér's V (or Cohen's w),
    `p` the p-value by `method`. `corrected` is the p-value after Holm's correction over the task's `judged` tests
    (`audit.balance.corrected_tests`). `effect` is the design effect: the number of questions that are worth one
    independent question.
    `least` is the weakest dependence detectable with a power of 0.8. `check` is the name of the check.
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
    check: str = "balance"


@dataclass(frozen=True)
class Probe:
    """The accuracy of a small classifier that sees only `sees`, on held-out questions.

    `family` is the type of its input. `right` of `questions` are correct (ties count in part), `chance` is the accuracy
    of guessing, `deviation` the standard deviation of the accuracy under guessing. (`low`, `high`) is the 95 % interval
    of the accuracy. A judged probe is `luck` if it is not significantly above chance. `least` is the smallest shortcut,
    in accuracy above chance, detectable with a power of 0.8. `learned` is the accuracy gained on injected shortcuts,
    None if nothing can be learned. A probe is not `judged` if its input is supposed to determine the answer.
    """

    task: str
    sees: str
    family: str
    questions: int
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
        """The share of questions answered correctly."""
        return self.right / self.questions if self.questions else 0.0


@dataclass(frozen=True)
class Counts:
    """The numbers of a task's instances and questions: planned, kept, and rejected by reason."""

    task: str
    dimension: str
    instances: int
    questions: int
    kept: int
    rejected: dict[str, int]


@dataclass(frozen=True)
class Likeness:
    """The similarity of the options of a task's questions: the share of pixels in which the closest two differ.

    `quantiles` are minimum, quartiles and maximum; `pairs` is the median for every pair of option names; `closest` is
    the question with the most similar options.
    """

    task: str
    quantiles: tuple[float, ...]
    pairs: dict[str, float]
    closest: str


@dataclass(frozen=True)
class Spread:
    """The distribution of a quantity, such as the stimulus difference, over a task's questions."""

    task: str
    name: str
    unit: str
    quantiles: tuple[float, ...]


@dataclass(frozen=True)
class Summary:
    """The one-line summary of a task: verdict, reasons, and amount of data.

    `verdict` is `unclear` if nothing fails but something is inconclusive. `groups` is the effective sample size: the
    number of independent control groups. Over the judged probes, `above` is the highest accuracy above chance, `best`
    its probe, and `least` the shortcut that all would have detected; None if nothing was probed. `stable` is the share
    of stable answers (`wmspec.dataset.audit.stability`), None if unknown.
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
    """All results of an audit."""

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
