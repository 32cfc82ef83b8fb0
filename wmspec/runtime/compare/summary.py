"""Summaries of many instances: agreement per pair of engines, and factors associated with disagreement."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from wmspec.compile.design.levels import Level
from wmspec.runtime.compare.model import CheckResult, Comparison, Pair


@dataclass(frozen=True)
class Share:
    """`good` out of `all`."""

    good: int
    all: int

    def __str__(self) -> str:
        return f"{self.good}/{self.all}"


@dataclass(frozen=True)
class TaskAgreement:
    """A task in a pair of engines.

    `answers` counts the questions that at least one engine accepts, `before_gates` all questions. `episodes` counts
    executed runs within tolerance, counterfactuals included. `median` and `largest` (m) summarize the largest gap of
    every episode. `late` (s) is the largest time difference of an event in both engines.
    """

    task: str
    engines: Pair
    answers: Share
    before_gates: Share
    episodes: Share
    median: float
    largest: float
    late: float


@dataclass(frozen=True)
class Suspect:
    """A level of a factor with more failures (`with_it`) than its other levels (`without`)."""

    task: str
    what: str
    factor: str
    value: Level
    with_it: Share
    without: Share


def lines(checked: Sequence[CheckResult], engines: Sequence[Pair]) -> tuple[TaskAgreement, ...]:
    """Return one line per task and pair of engines, in order."""
    tasks = dict.fromkeys(c.task for c in checked)
    return tuple(_line(task, pair, [c for c in checked if c.task == task]) for task in tasks for pair in engines)


def _line(task: str, pair: Pair, checked: Sequence[CheckResult]) -> TaskAgreement:
    verdicts = [v for c in checked for v in c.verdicts if v.engines == pair]
    accepted = [v for v in verdicts if v.is_accepted]
    compared = [k for c in checked for k in c.comparisons if k.engines == pair]
    gaps = sorted(_widest(k) for k in compared) or [0.0]
    late = [abs(e.times[0] - e.times[1]) for k in compared for e in k.events if None not in e.times]  # type: ignore[operator]
    return TaskAgreement(
        task=task,
        engines=pair,
        answers=Share(sum(v.agree for v in accepted), len(accepted)),
        before_gates=Share(sum(v.agree for v in verdicts), len(verdicts)),
        episodes=Share(sum(k.within for k in compared), len(compared)),
        median=gaps[len(gaps) // 2],
        largest=gaps[-1],
        late=max(late, default=0.0),
    )


def _widest(comparison: Comparison) -> float:
    return max((g.position for g in comparison.gaps), default=0.0)


def suspects(checked: Sequence[CheckResult]) -> tuple[Suspect, ...]:
    """Return the levels associated with disputed answers and diverging trajectories, the worst first."""
    tasks = dict.fromkeys(c.task for c in checked)
    kinds: tuple[tuple[str, Callable[[CheckResult], bool]], ...] = (
        ("answers differ", lambda c: any(not v.agree for v in c.verdicts)),
        ("trajectories part", lambda c: bool(c.parted)),
    )
    return tuple(
        suspect
        for task in tasks
        for what, wrong in kinds
        for suspect in _suspects(task, what, [c for c in checked if c.task == task], wrong)
    )


def _suspects(
    task: str, what: str, checked: Sequence[CheckResult], wrong: Callable[[CheckResult], bool]
) -> list[Suspect]:
    """Return levels with at least two cases, and twice the rate of the factor's other levels."""
    suspected = []
    for factor in checked[0].factors:
        for value in dict.fromkeys(c.factors[factor] for c in checked):
            with_it = _share([wrong(c) for c in checked if c.factors[factor] == value])
            without = _share([wrong(c) for c in checked if c.factors[factor] != value])
            if with_it.good >= 2 and without.all and with_it.good * without.all >= 2 * without.good * with_it.all:
                suspected.append(Suspect(task, what, factor, value, with_it, without))
    suspected.sort(
        key=lambda s: (s.without.good / s.without.all - s.with_it.good / s.with_it.all, s.factor, str(s.value))
    )
    return suspected[:3]


@dataclass(frozen=True)
class UnreliableAnswers:
    """Answers of a task that rest on a regime: their share, and an example."""

    task: str
    kind: str
    answers: Share
    instance: int
    where: str


def unreliable_answers(checked: Sequence[CheckResult]) -> tuple[UnreliableAnswers, ...]:
    """Return the regimes that answers rest on, by task; agreement is no evidence there."""
    rows: dict[tuple[str, str], UnreliableAnswers] = {}
    for task in dict.fromkeys(c.task for c in checked):
        verdicts = [(c.index, v) for c in checked if c.task == task for v in c.verdicts]
        for index, regime in [(index, regime) for index, v in verdicts for regime in v.regimes]:
            resting = sum(any(r.kind == regime.kind for r in v.regimes) for _, v in verdicts)
            row = UnreliableAnswers(task, regime.kind, Share(resting, len(verdicts)), index, regime.where)
            rows.setdefault((task, regime.kind), row)
    return tuple(rows.values())


def _share(wrong: Sequence[bool]) -> Share:
    return Share(sum(wrong), len(wrong))
