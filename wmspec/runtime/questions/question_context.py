"""One question of an executed instance: what its kind answers it from, and how the answers of runs are told apart."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Protocol

from wmspec.compile.layout.values import Values
from wmspec.core.diagnostics import WmsError
from wmspec.core.rng import bits
from wmspec.lang.check.ir.ir import Counterfactual, Question
from wmspec.runtime.questions.measure import Measured
from wmspec.runtime.questions.model import Reject
from wmspec.runtime.questions.observed import Observed
from wmspec.runtime.questions.referring_expressions import Ambiguous
from wmspec.runtime.questions.runs import EnginePair, Run
from wmspec.runtime.questions.views import View, views_of


@dataclass(frozen=True)
class Asking:
    """A question, the `run` of what happens, and who executes what would have happened under a counterfactual."""

    question: Question
    run: Run
    execute: Callable[[Counterfactual], Run]
    pair: EnginePair

    @property
    def values(self) -> Values:
        """The values of the spec before the episode."""
        return self.run.values

    @cached_property
    def views(self) -> Sequence[View]:
        """What is shown with the question."""
        return views_of(self.values.spec, self.values)

    @cached_property
    def observed(self) -> Observed:
        """What happens, as it is shown."""
        return self.run.observed(self.views, self.pair)

    @cached_property
    def measured(self) -> Measured:
        """What is measured on what happens."""
        return Measured(self.values, self.observed)

    def measured_on(self, run: Run) -> Measured:
        """What is measured on another run, from the same views."""
        return Measured(run.values, run.observed(self.views, self.pair))

    @cached_property
    def changes(self) -> tuple[Counterfactual, ...]:
        """The question's counterfactuals, of this instance."""
        return self.question.alternatives(self.values.own)

    @cached_property
    def alternatives(self) -> tuple[Run, ...]:
        """What would have happened under each of them. Raises Reject as executing does."""
        return tuple(map(self.execute, self.changes))


class AnswerSlot(Protocol):
    """Where the truth goes among the options, and the others."""

    def order(self, truth: int, n: int) -> list[int]:
        """The options 0..n-1 in order, the truth at its place."""


@dataclass(frozen=True)
class ShuffledSlot:
    """The truth goes to `position` modulo the number of options; `key` decides the order of the others."""

    position: int
    key: tuple[object, ...]

    def order(self, truth: int, n: int) -> list[int]:
        """The options 0..n-1 in order, the truth at its place."""
        others = sorted((i for i in range(n) if i != truth), key=lambda i: bits(*self.key, i))
        others.insert(self.position % n, truth)
        return others


@dataclass(frozen=True)
class ClosedSlot:
    """The order of a closed set, the same whichever member is true: every member's place, and which is the truth."""

    places: tuple[int, ...]
    member: int

    def order(self, truth: int, n: int) -> list[int]:
        """The members in order, of which the truth comes first in 0..n-1 and then the others."""
        assert truth == 0 and n == len(self.places)  # noqa: PT018
        listed = [self.member, *(m for m in range(n) if m != self.member)]
        return sorted(range(n), key=lambda i: self.places[listed[i]])


def refused(error: WmsError) -> Reject:
    """Why an instance whose values lead to an error, a division by a speed of zero, say, yields no question."""
    return Reject("alike" if isinstance(error, Ambiguous) else "invalid", str(error))
