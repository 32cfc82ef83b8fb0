"""Clauses that each kind of question allows. `wmspec.runtime.questions.kinds` implements the kinds."""

from __future__ import annotations

from collections.abc import Callable, Set
from dataclasses import dataclass

from wmspec.lang.check.ir import ir
from wmspec.lang.check.types.types import PICTURE, POSSIBILITY, TRUTH, Quantity, Type

#: Keyword of the answer's clause, and the pseudo-clause of counterfactuals.
ANSWER, COUNTERFACTUAL = "answer", "counterfactual"
#: A closed set of options: the pictures of the siblings in the group.
ORBIT = "orbit"


@dataclass(frozen=True)
class ClauseRule:
    """A clause that a kind of question requires or refuses: `message` (`{answer}` is the answer's type) and `remedy`.

    The error is located `at` a clause, by default its own. The rule applies `where` the answer's type matches; always,
    if None.
    """

    clause: str
    message: str
    remedy: str
    at: str = ""
    where: Callable[[Type], bool] | None = None

    def applies_to(self, answer: Type) -> bool:
        """Whether the rule applies to answers of this type."""
        return self.where is None or self.where(answer)


@dataclass(frozen=True)
class QuestionRules:
    """A kind of question: the answers and clauses that select it, and the rules for its clauses.

    A `spoken` kind is answered in words, so its values must have a wording.
    """

    fits: Callable[[Type, Set[str]], bool]
    spoken: bool
    refused: tuple[ClauseRule, ...] = ()
    needed: tuple[ClauseRule, ...] = ()


def _quantity(answer: Type) -> bool:
    return isinstance(answer, Quantity)


_NO_COUNTERFACTUALS = ClauseRule(
    clause=COUNTERFACTUAL,
    message="counterfactuals are the options of picture questions",
    remedy="answer with `frame(CAMERA, TIME)`",
)
_NO_DISTANCE = ClauseRule(
    clause="distinct",
    message="`distinct by` is for options that are pictures, and the answer is {answer}",
    remedy="remove it",
)
_NO_TOLERANCE = ClauseRule(
    clause="within",
    message="`within` is for answers that are quantities, and this one is {answer}",
    remedy="remove it",
)

_NO_ORBIT = ClauseRule(
    clause=ORBIT,
    message="an orbit is the options of a picture question, and the answer to this is {answer}",
    remedy="answer with `frame(CAMERA, TIME)`, or list the options: `options [...]`",
)
_NO_KINDS = ClauseRule(
    clause="kinds",
    message="`kinds` are those of outcomes that pictures show, and the answer to this is {answer}",
    remedy="ask for the kind itself: `answer if CONDITION then ... else ...`",
)

#: Kinds of questions; the first that fits applies.
QUESTION_RULES: dict[ir.QuestionKind, QuestionRules] = {
    "pictures": QuestionRules(
        fits=lambda answer, _: answer == PICTURE,
        spoken=False,
        refused=(
            ClauseRule("options", "the options of a picture question are its counterfactuals", "remove `options`"),
            _NO_TOLERANCE,
        ),
        needed=(
            ClauseRule(
                clause=COUNTERFACTUAL,
                message="a picture question needs counterfactuals to choose from",
                remedy="add `counterfactual NAME { ... }`, or `options orbit of FACTOR, ...`",
                at=ANSWER,
            ),
        ),
    ),
    "possible": QuestionRules(
        fits=lambda answer, _: answer == POSSIBILITY,
        spoken=False,
        refused=(
            _NO_ORBIT,
            _NO_KINDS,
            _NO_COUNTERFACTUALS,
            _NO_TOLERANCE,
            _NO_DISTANCE,
            ClauseRule(
                clause="options",
                message="the options of `answer possible` are possible and impossible",
                remedy="remove `options`",
            ),
        ),
    ),
    "numbers": QuestionRules(
        fits=lambda answer, clauses: _quantity(answer) and "within" in clauses,
        spoken=True,
        refused=(
            _NO_ORBIT,
            _NO_KINDS,
            _NO_COUNTERFACTUALS,
            _NO_DISTANCE,
            ClauseRule(
                clause="options",
                message="an answer is one of its options or open, not both",
                remedy="remove `options` or `within`",
                at="within",
            ),
        ),
    ),
    "labels": QuestionRules(
        fits=lambda answer, _: answer != PICTURE,
        spoken=True,
        refused=(_NO_ORBIT, _NO_KINDS, _NO_COUNTERFACTUALS, _NO_TOLERANCE, _NO_DISTANCE),
        needed=(
            ClauseRule(
                clause="options",
                message="the answer is {answer}, but there are no options",
                remedy="add `options [...]` or, to ask for it openly, `within TOLERANCE`",
                at=ANSWER,
                where=_quantity,
            ),
            ClauseRule(
                clause="options",
                message="the answer is {answer}, but there are no options",
                remedy="add `options [...]`",
                at=ANSWER,
                where=lambda answer: answer != TRUTH and not _quantity(answer),
            ),
        ),
    ),
}


def question_kind(answer: Type, clauses: Set[str]) -> ir.QuestionKind:
    """Return the kind of a question with this type of answer and these clauses."""
    return next(name for name, rules in QUESTION_RULES.items() if rules.fits(answer, clauses))


def has_countable_answers(question: ir.Question) -> bool:
    """Whether the answers of a question are names, whose frequencies can be counted."""
    return question.kind in ("labels", "possible")


def violated_rule(rules: QuestionRules, answer: Type, clauses: Set[str]) -> ClauseRule | None:
    """Return the first rule that a question violates, or None."""
    refused = (rule for rule in rules.refused if rule.clause in clauses and rule.applies_to(answer))
    needed = (rule for rule in rules.needed if rule.clause not in clauses and rule.applies_to(answer))
    return next((rule for some in (refused, needed) for rule in some), None)
