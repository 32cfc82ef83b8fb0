"""Open questions: a number is asked for, and is right within so much of the one that was measured."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from wmspec.lang.check.ir.evaluate import evaluate
from wmspec.lang.check.ir.ir import QuestionKind
from wmspec.runtime.questions.kinds.kind import Kind, in_words, quantity
from wmspec.runtime.questions.model import Answer, Number
from wmspec.runtime.questions.question_context import Asking
from wmspec.runtime.questions.runs import Run


@dataclass(frozen=True)
class NumberAnswer(Answer):
    """The `value` that is measured, and how far another may be off (SI)."""

    kind: ClassVar[QuestionKind] = "numbers"
    value: float
    within: float


class Numbers(Kind[NumberAnswer]):
    """The answer is what is near enough. There are no options."""

    def answer(self, asking: Asking) -> NumberAnswer:
        """What is measured."""
        assert asking.question.within is not None
        value = evaluate(asking.question.answer, asking.measured)
        return NumberAnswer(value, evaluate(asking.question.within, asking.values))

    def words(self, asking: Asking, answer: NumberAnswer) -> str:
        """The value with its unit."""
        return in_words(asking, answer.value)

    def disturbed(self, asking: Asking, answer: NumberAnswer, nudged: Run, by: float) -> str:
        """Whether what is measured is no longer near enough."""
        now = evaluate(asking.question.answer, asking.measured_on(nudged))
        if abs(answer.value - now) <= answer.within:
            return ""
        return f"{answer.value} becomes {now} when everything free is set aside by {by * 1000:g} mm"

    def number(self, asking: Asking, answer: NumberAnswer) -> Number | None:
        """The value, and how far off is still right."""
        return quantity(answer.value, asking.question.sort, answer.within)

    def agree(self, a: NumberAnswer, b: NumberAnswer) -> bool:
        """Whether the one would be right where the other is asked."""
        return abs(a.value - b.value) <= a.within

    def remedy(self, sort: str) -> str:
        """What is right may lie further from what is wrong."""
        return "ask for a larger margin"
