"""Numeric questions, scored with an absolute tolerance."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from wmspec.lang.check.ir.evaluate import evaluate
from wmspec.lang.check.ir.ir import QuestionKind
from wmspec.runtime.questions.kinds.kind import Kind, actual_value, actual_words, in_words, nudged_value, quantity
from wmspec.runtime.questions.model import Answer, Number
from wmspec.runtime.questions.question_context import QuestionContext
from wmspec.runtime.questions.runs import Run


@dataclass(frozen=True)
class NumberAnswer(Answer):
    """The measured `value` and the tolerance `within` (SI)."""

    kind: ClassVar[QuestionKind] = "numbers"
    value: float
    within: float


class Numbers(Kind[NumberAnswer]):
    """An open question: every number within tolerance is right."""

    def answer(self, asking: QuestionContext) -> NumberAnswer:
        """Return the measured value."""
        assert asking.question.within is not None
        value = evaluate(asking.question.answer, asking.measured)
        actual = actual_value(asking, asking.measured)
        within = evaluate(asking.question.within, asking.values)
        return NumberAnswer(value, within, actual=actual, actual_words=actual_words(asking, actual))

    def words(self, asking: QuestionContext, answer: NumberAnswer) -> str:
        """Return the value with its unit."""
        return in_words(asking, answer.value)

    def change_under_nudge(self, asking: QuestionContext, answer: NumberAnswer, nudged: Run, by: float) -> str:
        """Return the other measured value if it is out of tolerance, or ''."""
        now, actual = nudged_value(asking, nudged)
        if not _is_near(answer.actual, actual, answer.within):
            return f"as it is, {answer.actual} becomes {actual} when free bodies are displaced by {by * 1000:g} mm"
        if abs(answer.value - now) <= answer.within:
            return ""
        return f"{answer.value} becomes {now} when free bodies are displaced by {by * 1000:g} mm"

    def number(self, asking: QuestionContext, answer: NumberAnswer) -> Number | None:
        """Return value and tolerance."""
        return quantity(answer.value, asking.question.sort, answer.within)

    def agree(self, a: NumberAnswer, b: NumberAnswer) -> bool:
        """Whether each value is within tolerance of the other, those without the change of a what-if too."""
        return abs(a.value - b.value) <= a.within and _is_near(a.actual, b.actual, a.within)

    def remedy(self, sort: str) -> str:
        """Return the remedy: increase the tolerance or the margin."""
        return "use a larger margin"


def _is_near(a: float | None, b: float | None, within: float) -> bool:
    """Whether two values that may be undefined are within tolerance."""
    return a is b if a is None or b is None else abs(a - b) <= within
