"""The gates that a question must pass before a picture is drawn: ensures, margins, options that are told apart."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations
from math import log

import numpy as np
from numpy.typing import NDArray

from wmspec.ask.measure import Measured
from wmspec.ask.model import Reject
from wmspec.check.evaluate import evaluate
from wmspec.check.ir import Margin, Question


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


def apart(a: NDArray[np.float64], b: NDArray[np.float64]) -> float:
    """How far (m) the body that differs most between two outcomes (n, 7) is from itself.

    Infinitely far if it is in one of them alone (NaN in the other).
    """
    gaps = np.linalg.norm(a[:, :3] - b[:, :3], axis=1)
    gone = np.isnan(a[:, 0]), np.isnan(b[:, 0])
    gaps = np.where(gone[0] != gone[1], np.inf, np.where(gone[0], 0.0, gaps))
    return float(gaps.max(initial=0.0))


def distinct(poses: NDArray[np.float64], names: Sequence[str], least: float) -> None:
    """Raise Reject if two of the outcomes (options, n, 7) are less than `least` (m) apart."""
    for i, j in combinations(range(len(names)), 2):
        gap = apart(poses[i], poses[j])
        if gap < least:
            raise Reject(
                "alike", f"{names[i]} and {names[j]}: {gap * 100:.1f} cm apart, {least * 100:.1f} cm asked for"
            )
