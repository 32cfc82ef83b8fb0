"""Results of a crosscheck: plain values in SI units, picklable and JSON-compatible."""

from __future__ import annotations

from dataclasses import dataclass, field

from wmspec.compile.design.levels import Level
from wmspec.lang.check.ir.ir import QuestionKind

#: The names of two engines, in the requested order.
Pair = tuple[str, str]


@dataclass(frozen=True)
class Gap:
    """The divergence of one body between two engines.

    `position` (m) and `angle` (rad, visible rotation only) are the largest gaps. `allowed` (m) is the tolerance at the
    time of the position gap, `end` (m) the gap at the end. `began` (s) is when a gap first exceeded its tolerance, or
    None.
    """

    body: str
    position: float
    allowed: float
    angle: float
    end: float
    began: float | None


@dataclass(frozen=True)
class Event:
    """The first contact (s) of two bodies, initially apart, in each engine; None without contact."""

    first: str
    second: str
    times: tuple[float | None, float | None]
    within: bool


@dataclass(frozen=True)
class Rest:
    """A body at rest at the end in one engine only, with its speeds (m/s)."""

    body: str
    speeds: tuple[float, float]


@dataclass(frozen=True)
class Cause:
    """The first divergence of two engines: body, time (s), previous contact, and decisive properties.

    `mass` (kg) holds the partners' masses (0 for immovable ones); `friction` and `restitution` are those of the pair.
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
    """Motion that engines get wrong, even when they agree: its kind, and where it occurs in the episode."""

    kind: str
    where: str

    @property
    def sentence(self) -> str:
        """Both in a sentence."""
        return f"{self.kind}: {self.where}"


@dataclass(frozen=True)
class Comparison:
    """One episode in two engines. `run` is `truth` or a counterfactual; `cause` is None within tolerance."""

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

    `kind` is that of the question, `sort` that of its answer. `answers` are texts. `rejected` is the gate that rejects
    the question in an engine, or None. `agree` holds if each engine's outcome selects the other's answer, independent
    of gates. `regimes` occur in the question's runs; agreement is then no evidence.
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
    def is_accepted(self) -> bool:
        """Whether at least one engine's gates accept the question."""
        return None in self.rejected

    @property
    def disputed(self) -> bool:
        """Whether the question is accepted, and the other engine has another answer."""
        return self.is_accepted and not self.agree


@dataclass(frozen=True)
class Failure:
    """An engine that could not execute a run, with the reason; `engine` is '' if the scene is invalid."""

    engine: str
    run: str
    reason: str


@dataclass(frozen=True)
class CheckResult:
    """All results for one instance."""

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
        """The episodes out of tolerance."""
        return tuple(c for c in self.comparisons if not c.within)

    def passes(self, strict: bool) -> bool:
        """Whether the engines agree: on answers, and if `strict` (or without questions) on trajectories."""
        decided_by_path = strict or not self.verdicts
        return not self.failures and not self.disputed and not (decided_by_path and self.parted)
