"""What every kind of question does: answer, offer options, compare answers, and say what a row holds of it."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Generic, TypeVar

from wmspec.lang.check.ir.ir import Counterfactual, Level, Question
from wmspec.runtime.questions.model import Answer, Number, Option, Picture
from wmspec.runtime.questions.question_context import AnswerSlot, Asking
from wmspec.runtime.questions.runs import Run
from wmspec.runtime.questions.verbalize import filled, say_option, si_unit


@dataclass(frozen=True)
class Depicted:
    """A picture that is an option: its name, and of which run, from which camera and when (s) it is."""

    name: str
    run: Run
    camera: str
    time: float


@dataclass(frozen=True)
class Offered:
    """The options as a row holds them: `texts` (None if they are pictures; empty if there are none) and `pictures`."""

    texts: tuple[str, ...] | None
    pictures: tuple[Picture, ...] = ()


A = TypeVar("A", bound=Answer)


class Kind(ABC, Generic[A]):
    """One kind of question; it has no options unless it says more than it must.

    `ask` calls `answer`, `gate`, `disturbed` after every nudge, and `options`; a crosscheck calls `answer` and `gate`.
    Engines are then compared by their answers alone, which hold whatever can be told without drawing a picture.
    """

    def executed(self, question: Question, levels: Mapping[str, Level]) -> tuple[Counterfactual, ...]:
        """The counterfactuals that have to be executed, of an instance with these levels of its factors."""
        return ()

    @abstractmethod
    def answer(self, asking: Asking) -> A:
        """The answer, before any gate. Raises WmsError if it has no value."""

    @abstractmethod
    def words(self, asking: Asking, answer: A) -> str:
        """The answer in words. Raises Ambiguous if words cannot tell it."""

    def gate(self, asking: Asking, answer: A) -> None:
        """Raise Reject if the options are not what they should be, as far as can be told without drawing them."""

    @abstractmethod
    def disturbed(self, asking: Asking, answer: A, nudged: Run, by: float) -> str:
        """Why the answer does not hold when everything free is set aside by so much (m); empty if it does."""

    def depicted(self, asking: Asking, answer: A) -> Sequence[Depicted]:
        """The pictures that are options."""
        return ()

    def options(self, asking: Asking, answer: A, slot: AnswerSlot) -> tuple[Option, ...]:
        """The options in order, the true one at its slot. Raises Reject if two look alike."""
        return ()

    def number(self, asking: Asking, answer: A) -> Number | None:
        """The answer as a number, if it is one."""
        return None

    def picked(self, mine: A, other: A) -> str | None:
        """The name of the option of mine that the other engine's outcome picks; None if it picks none."""
        return None

    @abstractmethod
    def agree(self, a: A, b: A) -> bool:
        """Whether each engine's outcome picks the other's answer."""

    def compared(self, a: A, b: A, engines: tuple[str, str]) -> str:
        """How far apart two answers are, for a person; empty if their words say all of it."""
        return ""

    @abstractmethod
    def remedy(self, sort: str) -> str:
        """What to do about an answer (of a sort of value) that the least difference between engines decides."""

    def offered(self, options: Sequence[Option]) -> Offered:
        """The options as a row holds them."""
        return Offered(())


def quantity(value: Any, sort: str, within: float | None = None) -> Number | None:
    """A value of a sort with its SI unit, if it is a number."""
    return Number(value, si_unit(sort), within) if isinstance(value, float) else None


def in_words(asking: Asking, value: Any) -> str:
    """A value of the question's sort in words that stand alone. Raises Ambiguous if words cannot tell it."""
    parts = next((text.parts for text in asking.question.texts if text.text == value), None)
    if parts is not None:
        return filled(parts, asking.measured, asking.values)
    return say_option(value, asking.question.sort, asking.values)
