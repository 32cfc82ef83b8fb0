"""Which clauses each kind of question allows. `wmspec.runtime.questions.kinds` asks and compares them."""

from __future__ import annotations

from collections.abc import Callable, Set
from dataclasses import dataclass

from wmspec.lang.check.ir import ir
from wmspec.lang.check.types.types import PICTURE, TRUTH, Quantity, Type

#: The clause in which a question says what it is asked for, and what stands for its counterfactuals beside clauses.
ANSWER, COUNTERFACTUAL = "answer", "counterfactual"
#: A closed set of options: the pictures of the siblings in the group.
ORBIT = "orbit"


@dataclass(frozen=True)
class Rule:
    """A clause that a kind of question needs or refuses: `message` (`{answer}` is what the answer is) and `remedy`.

    It is pointed out `at` a clause. It holds `where` the answer is of such a kind; always, if None.
    """

    clause: str
    message: str
    remedy: str
    at: str
    where: Callable[[Type], bool] | None = None

    def holds(self, answer: Type) -> bool:
        """Whether the rule is one for such answers."""
        return self.where is None or self.where(answer)


@dataclass(frozen=True)
class QuestionRules:
    """A kind of question: which answers, with which clauses beside them, make it, and the rules for its clauses.

    What is `spoken` is answered in words, so that its values must have some.
    """

    fits: Callable[[Type, Set[str]], bool]
    spoken: bool
    refused: tuple[Rule, ...] = ()
    needed: tuple[Rule, ...] = ()


def _quantity(answer: Type) -> bool:
    return isinstance(answer, Quantity)


_NO_COUNTERFACTUALS = Rule(
    clause=COUNTERFACTUAL,
    message="counterfactuals are the options of picture questions",
    remedy="answer with `frame(CAMERA, TIME)`",
    at=COUNTERFACTUAL,
)
_NO_DISTANCE = Rule(
    clause="distinct",
    message="`distinct by` is for options that are pictures, and the answer is {answer}",
    remedy="remove it",
    at="distinct",
)
_NO_TOLERANCE = Rule(
    clause="within",
    message="`within` is for answers that are quantities, and this one is {answer}",
    remedy="remove it",
    at="within",
)

_NO_ORBIT = Rule(
    clause=ORBIT,
    message="an orbit is the options of a picture question, and the answer to this is {answer}",
    remedy="answer with `frame(CAMERA, TIME)`, or list the options: `options [...]`",
    at=ORBIT,
)
_NO_KINDS = Rule(
    clause="kinds",
    message="`kinds` are those of outcomes that pictures show, and the answer to this is {answer}",
    remedy="ask for the kind itself: `answer if CONDITION then ... else ...`",
    at="kinds",
)

#: The first kind that fits is that of a question.
QUESTION_RULES: dict[ir.QuestionKind, QuestionRules] = {
    "pictures": QuestionRules(
        fits=lambda answer, _: answer == PICTURE,
        spoken=False,
        refused=(
            Rule("options", "the options of a picture question are its counterfactuals", "remove `options`", "options"),
            _NO_TOLERANCE,
        ),
        needed=(
            Rule(
                clause=COUNTERFACTUAL,
                message="a picture question needs counterfactuals to choose from",
                remedy="add `counterfactual NAME { ... }`, or `options orbit of FACTOR, ...`",
                at=ANSWER,
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
            Rule(
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
            Rule(
                clause="options",
                message="the answer is {answer}, but there are no options",
                remedy="add `options [...]` or, to ask for it openly, `within TOLERANCE`",
                at=ANSWER,
                where=_quantity,
            ),
            Rule(
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
    """The kind of a question that has such an answer and these clauses."""
    return next(name for name, rules in QUESTION_RULES.items() if rules.fits(answer, clauses))


def counted(question: ir.Question) -> bool:
    """Whether a question's answers are names, of which one can count how often each comes."""
    return question.kind == "labels"


def broken(rules: QuestionRules, answer: Type, clauses: Set[str]) -> Rule | None:
    """The first rule for its clauses that a question breaks."""
    refused = (rule for rule in rules.refused if rule.clause in clauses and rule.holds(answer))
    needed = (rule for rule in rules.needed if rule.clause not in clauses and rule.holds(answer))
    return next((rule for some in (refused, needed) for rule in some), None)
