"""Values of questions that are known before the episode: whether a question is posed, and its time."""

from __future__ import annotations

from collections.abc import Iterable

from wmspec.compile.layout.evaluator import Evaluator
from wmspec.lang.check.expressions.measured import is_measured
from wmspec.lang.check.ir.evaluate import NoValue, evaluate
from wmspec.lang.check.ir.ir import Call, Operation, Question, WhatIf

#: s: closer times are the same.
_MOMENT = 1e-6


def is_posed(question: Question, values: Evaluator) -> bool:
    """Whether the conditions that are known before the episode hold."""
    known = (e.condition for e in question.ensures if not is_measured(values.spec, e.condition))
    return all(evaluate(condition, values) for condition in known)


def required_objects(
    question: Question, values: Evaluator, names: Iterable[str], time: float | None = None
) -> set[str]:
    """Return those of the named objects that must be visible in a picture at `time` (s), or in any picture (None)."""
    needed = set(names)
    for each in question.visibility:
        if each.objects is None:
            return set()
        named = evaluate(each.objects, values)
        times = () if each.times is None else tuple(evaluate(each.times, values))
        if not any(time is None or abs(time - own) < _MOMENT for own in times):
            needed -= set(named if isinstance(named, tuple) else (named,))
    return needed


def answer_picture_time(question: Question, values: Evaluator) -> float | None:
    """Return the time (s) of the picture that is the answer; None for other answers and measured times."""
    answer = question.answer
    if isinstance(answer, WhatIf):
        answer = answer.value
    while isinstance(answer, Operation) and answer.operator == "if":
        condition, then, otherwise = answer.operands
        if is_measured(values.spec, condition):
            return None
        answer = then if evaluate(condition, values) else otherwise
    if not isinstance(answer, Call) or answer.function != "frame" or is_measured(values.spec, answer.arguments[1]):
        return None
    try:
        return float(evaluate(answer.arguments[1], values))
    except NoValue:
        return None
