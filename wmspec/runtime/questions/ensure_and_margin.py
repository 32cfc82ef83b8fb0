"""Gates for every kind of question, before pictures are drawn: `ensure` and margins."""

from __future__ import annotations

from math import log

from wmspec.lang.check.ir.evaluate import evaluate
from wmspec.lang.check.ir.ir import Margin, Question
from wmspec.runtime.questions.measure import Measured
from wmspec.runtime.questions.model import Reject


def smallest_margin(question: Question, measured: Measured) -> float | None:
    """Return the smallest margin relative to the required one; None without margins.

    Raises Reject if an `ensure` fails or a margin is not kept.
    """
    for ensure in question.ensures:
        if not evaluate(ensure.condition, measured):
            raise Reject("ensure", ensure.text)
    kept = [_margin(m, measured) for m in question.margins if m.unless is None or not evaluate(m.unless, measured)]
    return min(kept, default=None)


def _margin(margin: Margin, measured: Measured) -> float:
    """Return the distance of a value from its threshold relative to the required margin; rejects below one."""
    value, bound = evaluate(margin.value, measured), evaluate(margin.bound, measured)
    apart = _times_apart(value, bound) if margin.ratio else abs(value) / bound
    if not apart >= 1:
        raise Reject("margin", f"{value:.4g} where {bound:.4g} apart was required")
    return float(apart)


def _times_apart(ratio: float, factor: float) -> float:
    return abs(log(ratio)) / log(factor) if ratio > 0 and factor > 1 else 0.0
