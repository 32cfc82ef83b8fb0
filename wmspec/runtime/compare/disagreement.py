"""The disagreements of an instance: each with an identity that a baseline can hold, and an explanation."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

from wmspec.compile.design.levels import Level
from wmspec.runtime.compare.model import CheckResult
from wmspec.runtime.compare.verbalize import dispute, failure, parting

Kind = Literal["failure", "answers", "trajectories"]
Identity = tuple[object, ...]


@dataclass(frozen=True)
class Disagreement:
    """One reason why an instance does not pass.

    `failure`: one of the `engines` (none if the scene is invalid) could not execute a `run`. `answers`: two engines
    answer a `question` differently. `trajectories`: an episode is out of tolerance in two engines. `began` is the time
    (s) at which the trajectories diverge, or None.
    """

    task: str
    index: int
    factors: dict[str, Level]
    kind: Kind
    engines: tuple[str, ...]
    run: str
    question: int | None
    reason: str
    began: float | None = None

    @property
    def identity(self) -> Identity:
        """The disagreement without its explanation, whose numbers vary between engine versions."""
        factors = tuple(sorted((name, _hashable(level)) for name, level in self.factors.items()))
        return self.task, self.index, factors, self.kind, self.engines, self.run, self.question


def disagreements(checked: CheckResult, strict: bool) -> tuple[Disagreement, ...]:
    """Return all reasons why an instance does not pass; empty if it does."""
    if checked.passes(strict):
        return ()

    def of(
        kind: Kind,
        engines: Sequence[str],
        reason: str,
        run: str = "",
        question: int | None = None,
        began: float | None = None,
    ) -> Disagreement:
        own = (checked.task, checked.index, checked.factors)
        return Disagreement(*own, kind, tuple(engines), run, question, reason, began)

    every = [of("failure", (f.engine,) if f.engine else (), failure(f), f.run) for f in checked.failures]
    for v in checked.disputed:
        began = None if v.cause is None else v.cause.began
        every.append(of("answers", v.engines, dispute(v), v.cause.run if v.cause else "", v.question, began))
    if strict or not checked.verdicts:
        for c in checked.parted:
            began = None if c.cause is None else c.cause.began
            every.append(of("trajectories", c.engines, parting(c), c.run, None, began))
    return tuple(every)


def complaints(checked: CheckResult, strict: bool) -> list[str]:
    """Return all reasons why an instance does not pass, as sentences."""
    return [d.reason for d in disagreements(checked, strict)]


def _hashable(level: Level | list[float]) -> Level:
    return tuple(level) if isinstance(level, list | tuple) else level
