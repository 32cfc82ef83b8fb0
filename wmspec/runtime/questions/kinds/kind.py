"""The interface of a kind of question: answer, options, comparison of answers, and contents of rows."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, Generic, TypeVar

from wmspec.core.diagnostics import GraphicsError, WmsError
from wmspec.lang.check.ir.evaluate import evaluate
from wmspec.lang.check.ir.ir import Counterfactual, Level, Question, WhatIf
from wmspec.runtime.questions.measure import Measured
from wmspec.runtime.questions.model import Answer, Number, Option
from wmspec.runtime.questions.question_context import AnswerSlot, QuestionContext
from wmspec.runtime.questions.runs import Run
from wmspec.runtime.questions.verbalize import fill_template, si_unit, verbalize_option


@dataclass(frozen=True)
class OptionImage:
    """An option that is a picture: name, run, camera and time (s)."""

    name: str
    run: Run
    camera: str
    time: float


A = TypeVar("A", bound=Answer)


class Kind(ABC, Generic[A]):
    """One kind of question, by default without options.

    `ask` calls `answer`, `gate`, `change_under_nudge` after every nudge, and `options`; crosscheck calls `answer` and
    `gate`. Answers hold everything that is known without drawing, so that engines can be compared by them.
    """

    #: Whether answers are counted by their words.
    countable: ClassVar[bool] = False
    #: Whether the answer is about the course of the episode, not about the value of an expression.
    watched: ClassVar[bool] = False

    def executed(self, question: Question, levels: Mapping[str, Level]) -> tuple[Counterfactual, ...]:
        """Return the counterfactuals to execute for an instance with these factor levels, without what-ifs."""
        return ()

    @abstractmethod
    def answer(self, asking: QuestionContext) -> A:
        """Return the answer before gates. Raises WmsError if it is undefined."""

    @abstractmethod
    def words(self, asking: QuestionContext, answer: A) -> str:
        """Return the answer in words. Raises Ambiguous if words cannot express it."""

    def vote_words(self, value: str, option: int | None) -> str:
        """Return what an engine says: the answer in words, or the option that it selects (None for none)."""
        return f"answers {value}"

    def gate(self, asking: QuestionContext, answer: A) -> None:
        """Raise Reject if the options are invalid, as far as known without drawing."""

    @abstractmethod
    def change_under_nudge(self, asking: QuestionContext, answer: A, nudged: Run, by: float) -> str:
        """Return why the answer changes when free bodies are displaced by `by` metres, or ''."""

    def option_images(self, asking: QuestionContext, answer: A) -> Sequence[OptionImage]:
        """Return the options that are pictures."""
        return ()

    def options(self, asking: QuestionContext, answer: A, slot: AnswerSlot) -> tuple[Option, ...]:
        """Return the options in order with the truth at its slot. Raises Reject if two look alike."""
        return ()

    def number(self, asking: QuestionContext, answer: A) -> Number | None:
        """Return the answer as a number, if it is one."""
        return None

    def picked(self, mine: A, other: A) -> str | None:
        """Return the name of the option of `mine` that the other engine's outcome selects, or None."""
        return None

    @abstractmethod
    def agree(self, a: A, b: A) -> bool:
        """Whether the outcome of each engine selects the answer of the other."""

    def compared(self, a: A, b: A, engines: tuple[str, str]) -> str:
        """Return how far apart two answers are, in words; '' if the answers themselves say it."""
        return ""

    @abstractmethod
    def remedy(self, sort: str) -> str:
        """Return the remedy for an answer of type `sort` that depends on the smallest differences between engines."""


def actual_value(asking: QuestionContext, measured: Measured) -> Any:
    """Return what the expression of a what-if is without the change; None if undefined, and for other answers."""
    answer = asking.question.answer
    if not isinstance(answer, WhatIf):
        return None
    try:
        return evaluate(answer.value, measured)
    except GraphicsError:
        raise
    except WmsError:
        return None


def actual_words(asking: QuestionContext, value: Any) -> str | None:
    """Return the actual value in words; None if there is none or words cannot express it."""
    try:
        return None if value is None else in_words(asking, value)
    except WmsError:
        return None


def nudged_value(asking: QuestionContext, nudged: Run) -> tuple[Any, Any]:
    """Return the value of the answer and its actual value when free bodies are displaced."""
    measured = asking.measured_on(nudged)
    return evaluate(asking.question.answer, measured), actual_value(asking, measured)


def quantity(value: Any, sort: str, within: float | None = None) -> Number | None:
    """Return a value with its SI unit if it is a number."""
    return Number(value, si_unit(sort), within) if isinstance(value, float) else None


def in_words(asking: QuestionContext, value: Any) -> str:
    """Return a value of the question's type in words that stand alone. Raises Ambiguous if words cannot express it."""
    parts = next((text.parts for text in asking.question.texts if text.text == value), None)
    if parts is not None:
        return fill_template(parts, asking.measured, asking.values)
    return verbalize_option(value, asking.question.sort, asking.values)
