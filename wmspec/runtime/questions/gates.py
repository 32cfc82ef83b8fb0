"""The gates that every question must pass, whatever its kind, before a picture is drawn: ensures and margins."""

from __future__ import annotations

from math import log

from wmspec.lang.check.ir.evaluate import evaluate
from wmspec.lang.check.ir.ir import Margin, Question
from wmspec.runtime.questions.measure import Measured
from wmspec.runtime.questions.model import Reject


def passed(question: Question, measured: Measured) -> float | None:
    """The smallest margin, in multiples of what was asked for (None without one).

    Raises Reject if an `ensure` does not hold or a margin is not kept.
    """
    for ensure in question.ensures:
        if not evaluate(ensure.condition, measured):
            raise Reject("ensure", ensure.text)
    kept = [_margin(m, measured) for m in question.margins if m.unless is None or not evaluate(m.unless, measured)]
    return min(kept, default=None)


def _margin(margin: Margin, measured: Measured) -> float:
    """How far the margin's value is from turning, in multiples of what was asked for; rejects below one."""
    value, bound = evaluate(margin.value, measured), evaluate(margin.bound, measured)
    apart = _times_apart(value, bound) if margin.ratio else abs(value) / bound
    if not apart >= 1:
        raise Reject("margin", f"{value:.4g} where {bound:.4g} apart was asked for")
    return float(apart)


def _times_apart(ratio: float, factor: float) -> float:
    return abs(log(ratio)) / log(factor) if ratio > 0 and factor > 1 else 0.0
