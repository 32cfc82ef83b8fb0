"""The context of one question: spec, run, alternatives and measured values."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Protocol

from wmspec.compile.design.what_ifs import what_ifs
from wmspec.compile.layout.evaluator import Evaluator
from wmspec.core.diagnostics import WmsError
from wmspec.core.rng import bits
from wmspec.lang.check.ir.evaluate import NoCause, Unchanged
from wmspec.lang.check.ir.ir import Counterfactual, Question
from wmspec.runtime.questions.declared_visibility import DeclaredVisibility, declared_visibility
from wmspec.runtime.questions.measure import Measured
from wmspec.runtime.questions.model import Reason, Reject
from wmspec.runtime.questions.observed import Observed
from wmspec.runtime.questions.referring_expressions import Ambiguous
from wmspec.runtime.questions.runs import EnginePair, Run
from wmspec.runtime.questions.views import View, views_of


@dataclass(frozen=True)
class QuestionContext:
    """A question and the true `run`."""

    question: Question
    run: Run
    pair: EnginePair

    @property
    def values(self) -> Evaluator:
        """Values of the spec before the episode."""
        return self.run.values

    @cached_property
    def views(self) -> Sequence[View]:
        """The shown views."""
        return views_of(self.values.spec, self.values)

    @cached_property
    def observed(self) -> Observed:
        """Observations of the true run."""
        return self.run.observed(self.views, self.pair)

    @cached_property
    def declared(self) -> DeclaredVisibility:
        """The declared visibility of objects. Raises WmsError for times without a picture."""
        return declared_visibility(self.question, self.values, self.views)

    @cached_property
    def measured(self) -> Measured:
        """Measured values of the true run."""
        return self.measure(self.run, self.observed)

    def measured_on(self, run: Run) -> Measured:
        """Return measured values of another run from the same views."""
        return self.measure(run, run.observed(self.views, self.pair))

    def measure(self, run: Run, observed: Observed) -> Measured:
        """Return an environment of its own for a run and its observations."""
        return Measured(run.values, observed, lambda change: self.measured_on(run.under(change)))

    @cached_property
    def imagined(self) -> tuple[Run, ...]:
        """The run of each what-if of the question. Raises Reject if an execution fails."""
        return tuple(map(self.run.under, what_ifs(self.question, self.values)))

    @cached_property
    def changes(self) -> tuple[Counterfactual, ...]:
        """The counterfactuals of the question for this instance."""
        return self.question.alternatives(self.values.own)

    @cached_property
    def alternatives(self) -> tuple[Run, ...]:
        """The run of each counterfactual. Raises Reject if an execution fails."""
        return tuple(map(self.run.under, self.changes))


class AnswerSlot(Protocol):
    """The order of truth and other options."""

    def order(self, truth: int, n: int) -> list[int]:
        """Return the options 0..n-1 in order, with the truth at its place."""


@dataclass(frozen=True)
class ShuffledSlot:
    """The truth is at `position` modulo the number of options; `key` orders the others."""

    position: int
    key: tuple[object, ...]

    def order(self, truth: int, n: int) -> list[int]:
        """Return the options 0..n-1 in order, with the truth at its place."""
        others = sorted((i for i in range(n) if i != truth), key=lambda i: bits(*self.key, i))
        others.insert(self.position % n, truth)
        return others


@dataclass(frozen=True)
class ClosedSlot:
    """The order of a closed set, equal for every true member: the place of each member, and the true one."""

    places: tuple[int, ...]
    member: int

    def order(self, truth: int, n: int) -> list[int]:
        """Return the members in order; in 0..n-1 the truth comes first, then the others."""
        assert truth == 0 and n == len(self.places)  # noqa: PT018
        listed = [self.member, *(m for m in range(n) if m != self.member)]
        return sorted(range(n), key=lambda i: self.places[listed[i]])


def rejection_of(error: WmsError) -> Reject:
    """Return the rejection for an instance whose values lead to an error, such as a division by zero."""
    reasons: dict[type[WmsError], Reason] = {Ambiguous: "alike", NoCause: "cause", Unchanged: "unchanged"}
    return Reject(reasons.get(type(error), "invalid"), error.portable)
