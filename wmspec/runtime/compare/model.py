"""What a crosscheck finds: values only, in SI units, so that they cross processes and become JSON as they are."""

from __future__ import annotations

from dataclasses import dataclass, field

from wmspec.compile.design.levels import Level
from wmspec.lang.check.ir.ir import QuestionKind

#: The names of two engines, in the order in which they were asked for.
Pair = tuple[str, str]


@dataclass(frozen=True)
class Gap:
    """How far one body parts between two engines.

    `position` (m) and `angle` (rad, as far as it can be seen) are the largest gaps, `allowed` (m) what the tolerances
    give at the time of the former, `end` (m) the gap at the end, `began` (s) when a gap first exceeded what was
    allowed (None if never).
    """

    body: str
    position: float
    allowed: float
    angle: float
    end: float
    began: float | None


@dataclass(frozen=True)
class Event:
    """The first touch (s) of two bodies that did not touch at the start, in each engine (None if they never do)."""

    first: str
    second: str
    times: tuple[float | None, float | None]
    within: bool


@dataclass(frozen=True)
class Rest:
    """A body that has come to rest at the end in one engine and not in the other: its speeds (m/s)."""

    body: str
    speeds: tuple[float, float]


@dataclass(frozen=True)
class Cause:
    """Where two engines part first: the body, when (s), the last touch before that, and what decides such a touch.

    `mass` (kg) holds the partners' masses (0 for what cannot move), `friction` and `restitution` are those of the pair.
    """

    run: str
    body: str
    began: float
    other: str | None
    touched: float | None
    mass: tuple[float, float] | None
    friction: float | None
    restitution: float | None
    hint: str


@dataclass(frozen=True)
class Regime:
    """Motion that engines get wrong, whether or not they agree: what of it, and where it is in the episode."""

    kind: str
    where: str

    @property
    def told(self) -> str:
        """Both in a sentence."""
        return f"{self.kind}: {self.where}"


@dataclass(frozen=True)
class Comparison:
    """One episode in two engines. `run` is `truth` or the name of a counterfactual; `cause`: None within tolerance."""

    run: str
    engines: Pair
    gaps: tuple[Gap, ...]
    events: tuple[Event, ...]
    rests: tuple[Rest, ...]
    cause: Cause | None
    regimes: tuple[Regime, ...] = ()

    @property
    def within(self) -> bool:
        """Whether everything is within tolerance."""
        return not self.rests and all(g.began is None for g in self.gaps) and all(e.within for e in self.events)


@dataclass(frozen=True)
class Verdict:
    """One question in two engines.

    `kind` is that of the question and `sort` that of its answer's value, as the language names it. `answers` are what
    each engine says, in words. `rejected` is why an engine would not ask it (None if it would). `agree` holds if each
    engine's outcome picks the other's answer, whether or not it would be asked. `regimes`: what the runs that it rests
    on enter, so that agreement is no proof.
    """

    question: int
    kind: QuestionKind
    sort: str
    engines: Pair
    answers: tuple[str, str]
    rejected: tuple[str | None, str | None]
    agree: bool
    detail: str
    cause: Cause | None
    regimes: tuple[Regime, ...] = ()

    @property
    def asked(self) -> bool:
        """Whether either engine alone would ask it."""
        return None in self.rejected

    @property
    def disputed(self) -> bool:
        """Whether it would be asked, with another answer in the other engine."""
        return self.asked and not self.agree


@dataclass(frozen=True)
class Failure:
    """An engine that could not execute a run (or `engine` "": there is no such scene), and its reason."""

    engine: str
    run: str
    reason: str


@dataclass(frozen=True)
class Checked:
    """Everything about one instance."""

    task: str
    index: int
    factors: dict[str, Level]
    nuisances: dict[str, Level]
    comparisons: tuple[Comparison, ...] = ()
    verdicts: tuple[Verdict, ...] = ()
    failures: tuple[Failure, ...] = field(default=())

    @property
    def disputed(self) -> tuple[Verdict, ...]:
        """The questions whose answer depends on the engine."""
        return tuple(v for v in self.verdicts if v.disputed)

    @property
    def parted(self) -> tuple[Comparison, ...]:
        """The episodes that are out of tolerance."""
        return tuple(c for c in self.comparisons if not c.within)

    def passes(self, strict: bool) -> bool:
        """Whether the engines agree: on the answers, and if `strict` (or nothing is asked) on the trajectories too."""
        decided_by_path = strict or not self.verdicts
        return not self.failures and not self.disputed and not (decided_by_path and self.parted)
