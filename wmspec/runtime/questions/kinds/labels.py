"""Questions with options in words: an object, a word, one of several numbers, yes or no."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

from wmspec.lang.check.ir.evaluate import evaluate
from wmspec.lang.check.ir.ir import QuestionKind
from wmspec.lang.check.tables.vocabulary import WORDS
from wmspec.lang.check.types.types import TRUTH
from wmspec.runtime.questions.kinds.kind import Kind, actual_value, actual_words, in_words, nudged_value, quantity
from wmspec.runtime.questions.model import Answer, Number, Option, Reject
from wmspec.runtime.questions.question_context import AnswerSlot, QuestionContext
from wmspec.runtime.questions.runs import Run

#: Numbers within this relative or absolute (SI) difference are equal.
RELATIVE_TOLERANCE, ABSOLUTE_TOLERANCE = 1e-9, 1e-12


@dataclass(frozen=True)
class LabelAnswer(Answer):
    """The measured `value`, and the option values in order of the spec."""

    kind: ClassVar[QuestionKind] = "labels"
    value: Any
    choices: tuple[Any, ...]


class Labels(Kind[LabelAnswer]):
    """The answer is the option with the measured value."""

    countable = True

    def answer(self, asking: QuestionContext) -> LabelAnswer:
        """Return the measured value and the options."""
        assert asking.question.options is not None
        value = evaluate(asking.question.answer, asking.measured)
        actual = actual_value(asking, asking.measured)
        choices = tuple(evaluate(asking.question.options, asking.values))
        return LabelAnswer(value, choices, actual=actual, actual_words=actual_words(asking, actual))

    def words(self, asking: QuestionContext, answer: LabelAnswer) -> str:
        """Return the value in words."""
        return in_words(asking, answer.value)

    def gate(self, asking: QuestionContext, answer: LabelAnswer) -> None:
        """Raise Reject if the answer is not an option or two options read the same."""
        texts = [in_words(asking, choice) for choice in answer.choices]
        if _place(answer.value, answer) is None:
            raise Reject("invalid", f"the answer {self.words(asking, answer)} is not among the options")
        if len(set(texts)) < len(texts):
            raise Reject("alike", f"two options read the same: {', '.join(texts)}")

    def change_under_nudge(self, asking: QuestionContext, answer: LabelAnswer, nudged: Run, by: float) -> str:
        """Return the other measured value, or ''."""
        now, actual = nudged_value(asking, nudged)
        if not same(answer.actual, actual):
            return f"as it is, {answer.actual} becomes {actual} when free bodies are displaced by {by * 1000:g} mm"
        if same(answer.value, now):
            return ""
        return f"{answer.value} becomes {now} when free bodies are displaced by {by * 1000:g} mm"

    def options(self, asking: QuestionContext, answer: LabelAnswer, slot: AnswerSlot) -> tuple[Option, ...]:
        """Return the options in words."""
        truth = _place(answer.value, answer)
        assert truth is not None
        return tuple(
            Option(
                kind="truth" if i == truth else "label",
                name=_name(answer.choices[i]),
                text=in_words(asking, answer.choices[i]),
            )
            for i in slot.order(truth, len(answer.choices))
        )

    def number(self, asking: QuestionContext, answer: LabelAnswer) -> Number | None:
        """Return the value if it is a number."""
        return quantity(answer.value, asking.question.sort)

    def picked(self, mine: LabelAnswer, other: LabelAnswer) -> str | None:
        """Return the option with the other engine's value."""
        place = _place(other.value, mine)
        return None if place is None else _name(mine.choices[place])

    def agree(self, a: LabelAnswer, b: LabelAnswer) -> bool:
        """Whether the values are equal, those without the change of a what-if too."""
        return same(a.value, b.value) and same(a.actual, b.actual)

    def remedy(self, sort: str) -> str:
        """Return the remedy: a word changes where a quantity crosses a threshold."""
        if sort == str(TRUTH) or sort in WORDS:
            return (
                "it is on the brink of turning: let factors and places keep away from there, or ask for a `margin` "
                "of a quantity that decides it, such as a distance"
            )
        return "use a larger margin"


def same(a: Any, b: Any) -> bool:
    """Whether two values are equal up to rounding; directions modulo full turns."""
    if isinstance(a, float) and isinstance(b, float):
        return abs(a - b) <= ABSOLUTE_TOLERANCE + RELATIVE_TOLERANCE * abs(b)
    return bool(a == b)


def _place(value: Any, answer: LabelAnswer) -> int | None:
    """Return the index of a value among the options, or None."""
    return next((i for i, choice in enumerate(answer.choices) if same(choice, value)), None)


def _name(choice: Any) -> str:
    """Return the name of an option in the spec."""
    if isinstance(choice, float):
        return f"{choice:g}"
    return str(choice).lower() if isinstance(choice, bool) else str(choice)
