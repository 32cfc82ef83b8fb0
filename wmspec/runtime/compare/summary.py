"""Many instances in a few numbers: agreement per pair of engines, and the factors that go with disagreement."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from wmspec.compile.design.levels import Level
from wmspec.runtime.compare.model import Checked, Comparison, Pair


@dataclass(frozen=True)
class Share:
    """`good` of `all`."""

    good: int
    all: int

    def __str__(self) -> str:
        return f"{self.good}/{self.all}"


@dataclass(frozen=True)
class Line:
    """A task in a pair of engines.

    `answers` counts the questions that either engine alone would ask, `before_gates` all of them, `episodes` what was
    executed, counterfactuals included, and is within tolerance. `median` and `largest` (m) are of every episode's
    largest gap, `late` (s) is the largest difference of an event that happens in both.
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
    """A value of a factor with which more goes wrong (`with_it`: wrong of all) than with its other values."""

    task: str
    what: str
    factor: str
    value: Level
    with_it: Share
    without: Share


def lines(checked: Sequence[Checked], engines: Sequence[Pair]) -> tuple[Line, ...]:
    """One line per task and pair of engines, in order."""
    tasks = dict.fromkeys(c.task for c in checked)
    return tuple(_line(task, pair, [c for c in checked if c.task == task]) for task in tasks for pair in engines)


def _line(task: str, pair: Pair, checked: Sequence[Checked]) -> Line:
    verdicts = [v for c in checked for v in c.verdicts if v.engines == pair]
    asked = [v for v in verdicts if v.asked]
    compared = [k for c in checked for k in c.comparisons if k.engines == pair]
    gaps = sorted(_widest(k) for k in compared) or [0.0]
    late = [abs(e.times[0] - e.times[1]) for k in compared for e in k.events if None not in e.times]  # type: ignore[operator]
    return Line(
        task=task,
        engines=pair,
        answers=Share(sum(v.agree for v in asked), len(asked)),
        before_gates=Share(sum(v.agree for v in verdicts), len(verdicts)),
        episodes=Share(sum(k.within for k in compared), len(compared)),
        median=gaps[len(gaps) // 2],
        largest=gaps[-1],
        late=max(late, default=0.0),
    )


def _widest(comparison: Comparison) -> float:
    return max((g.position for g in comparison.gaps), default=0.0)


def suspects(checked: Sequence[Checked]) -> tuple[Suspect, ...]:
    """The values of factors that go with answers that differ, and with trajectories that part, the worst first."""
    tasks = dict.fromkeys(c.task for c in checked)
    kinds: tuple[tuple[str, Callable[[Checked], bool]], ...] = (
        ("answers differ", lambda c: any(not v.agree for v in c.verdicts)),
        ("trajectories part", lambda c: bool(c.parted)),
    )
    return tuple(
        suspect
        for task in tasks
        for what, wrong in kinds
        for suspect in _suspects(task, what, [c for c in checked if c.task == task], wrong)
    )


def _suspects(task: str, what: str, checked: Sequence[Checked], wrong: Callable[[Checked], bool]) -> list[Suspect]:
    """Values with at least two cases, and twice the rate of the factor's other values."""
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
class Doubtful:
    """Answers of a task that rest on motion that engines get wrong: how many of all, and where in one of them."""

    task: str
    kind: str
    answers: Share
    instance: int
    where: str


def doubtful(checked: Sequence[Checked]) -> tuple[Doubtful, ...]:
    """What answers rest on that is no proof though engines agree, by task."""
    rows: dict[tuple[str, str], Doubtful] = {}
    for task in dict.fromkeys(c.task for c in checked):
        verdicts = [(c.index, v) for c in checked if c.task == task for v in c.verdicts]
        for index, regime in [(index, regime) for index, v in verdicts for regime in v.regimes]:
            resting = sum(any(r.kind == regime.kind for r in v.regimes) for _, v in verdicts)
            told = Doubtful(task, regime.kind, Share(resting, len(verdicts)), index, regime.where)
            rows.setdefault((task, regime.kind), told)
    return tuple(rows.values())


def _share(wrong: Sequence[bool]) -> Share:
    return Share(sum(wrong), len(wrong))
