"""Questions with options in words: an object, a word, a number of several, yes or no."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

from wmspec.lang.check.ir.evaluate import evaluate
from wmspec.lang.check.ir.ir import QuestionKind
from wmspec.lang.check.tables.vocabulary import WORDS
from wmspec.lang.check.types.types import TRUTH
from wmspec.runtime.questions.kinds.kind import Kind, Offered, in_words, quantity
from wmspec.runtime.questions.model import Answer, Number, Option, Reject
from wmspec.runtime.questions.question_context import AnswerSlot, Asking
from wmspec.runtime.questions.runs import Run

#: Numbers that differ by less than this share of one another, or by less than that (SI), differ by rounding alone.
ROUNDING_SHARE, ROUNDING = 1e-9, 1e-12


@dataclass(frozen=True)
class LabelAnswer(Answer):
    """The `value` that is measured, and the values on offer in the order of the spec."""

    kind: ClassVar[QuestionKind] = "labels"
    value: Any
    choices: tuple[Any, ...]


class Labels(Kind[LabelAnswer]):
    """The answer is the option that has its value."""

    def answer(self, asking: Asking) -> LabelAnswer:
        """What is measured, and what is on offer."""
        assert asking.question.options is not None
        value = evaluate(asking.question.answer, asking.measured)
        return LabelAnswer(value, tuple(evaluate(asking.question.options, asking.values)))

    def words(self, asking: Asking, answer: LabelAnswer) -> str:
        """The value in words."""
        return in_words(asking, answer.value)

    def gate(self, asking: Asking, answer: LabelAnswer) -> None:
        """Raise Reject if the answer is not on offer, or if two options read the same."""
        texts = [in_words(asking, choice) for choice in answer.choices]
        if _place(answer.value, answer) is None:
            raise Reject("invalid", f"the answer {self.words(asking, answer)} is not among the options")
        if len(set(texts)) < len(texts):
            raise Reject("alike", f"two options read the same: {', '.join(texts)}")

    def disturbed(self, asking: Asking, answer: LabelAnswer, nudged: Run, by: float) -> str:
        """Whether another value is measured."""
        now = evaluate(asking.question.answer, asking.measured_on(nudged))
        if same(answer.value, now):
            return ""
        return f"{answer.value} becomes {now} when everything free is set aside by {by * 1000:g} mm"

    def options(self, asking: Asking, answer: LabelAnswer, slot: AnswerSlot) -> tuple[Option, ...]:
        """The choices in words."""
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

    def number(self, asking: Asking, answer: LabelAnswer) -> Number | None:
        """The value, if it is a number."""
        return quantity(answer.value, asking.question.sort)

    def picked(self, mine: LabelAnswer, other: LabelAnswer) -> str | None:
        """The option that has the other's value."""
        place = _place(other.value, mine)
        return None if place is None else _name(mine.choices[place])

    def agree(self, a: LabelAnswer, b: LabelAnswer) -> bool:
        """Whether the values are the same."""
        return same(a.value, b.value)

    def remedy(self, sort: str) -> str:
        """A word turns where a quantity does."""
        if sort == str(TRUTH) or sort in WORDS:
            return (
                "it is on the brink of turning: let factors and places keep away from there, or ask for a `margin` "
                "of a quantity that decides it, such as a distance"
            )
        return "ask for a larger margin"

    def offered(self, options: Sequence[Option]) -> Offered:
        """Texts."""
        return Offered(tuple(option.text for option in options if option.text is not None))


def same(a: Any, b: Any) -> bool:
    """Whether two values are one answer; numbers that differ by rounding alone are, and directions by whole turns."""
    if isinstance(a, float) and isinstance(b, float):
        return abs(a - b) <= ROUNDING + ROUNDING_SHARE * abs(b)
    return bool(a == b)


def _place(value: Any, answer: LabelAnswer) -> int | None:
    """The place of a value among the choices of an answer; None if it is none of them."""
    return next((i for i, choice in enumerate(answer.choices) if same(choice, value)), None)


def _name(choice: Any) -> str:
    """What the spec calls a choice."""
    if isinstance(choice, float):
        return f"{choice:g}"
    return str(choice).lower() if isinstance(choice, bool) else str(choice)
