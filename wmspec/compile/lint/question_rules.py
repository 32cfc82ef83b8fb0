"""Whether a question is asked, and of which moment, as far as that is known before the episode."""

from __future__ import annotations

from wmspec.compile.layout.values import Values
from wmspec.lang.check.expressions.measured import measured
from wmspec.lang.check.ir.evaluate import NoValue, evaluate
from wmspec.lang.check.ir.ir import Call, Operation, Question


def asked(question: Question, values: Values) -> bool:
    """Whether the conditions that can be looked at before the episode let the question be asked."""
    known = (e.condition for e in question.ensures if not measured(values.spec, e.condition))
    return all(evaluate(condition, values) for condition in known)


def pictured(question: Question, values: Values) -> float | None:
    """The time (s) of the picture that answers a question; None if it has another answer, or if it is measured."""
    answer = question.answer
    while isinstance(answer, Operation) and answer.operator == "if":
        condition, then, otherwise = answer.operands
        if measured(values.spec, condition):
            return None
        answer = then if evaluate(condition, values) else otherwise
    if not isinstance(answer, Call) or answer.function != "frame" or measured(values.spec, answer.arguments[1]):
        return None
    try:
        return float(evaluate(answer.arguments[1], values))
    except NoValue:
        return None
