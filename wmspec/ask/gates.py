"""The gates that a question must pass before a picture is drawn: ensures, margins, options that are told apart."""

from __future__ import annotations

from itertools import combinations
from math import log

import numpy as np
from numpy.typing import NDArray

from wmspec.ask.measure import Measured
from wmspec.ask.model import Reason
from wmspec.check.evaluate import evaluate
from wmspec.check.ir import Margin, Question


class Reject(Exception):
    """Why an instance yields no question."""

    def __init__(self, reason: Reason, detail: str) -> None:
        super().__init__(detail)
        self.reason: Reason = reason
        self.detail = detail


def passed(question: Question, measured: Measured) -> float | None:
    """The smallest margin, in multiples of what was asked for (None without one).

    Raises Reject if an `ensure` does not hold or a margin is not kept.
    """
    for ensure in question.ensures:
        if not evaluate(ensure.condition, measured):
            raise Reject("ensure", ensure.text)
    return min((_margin(m, measured) for m in question.margins), default=None)


def _margin(margin: Margin, measured: Measured) -> float:
    """How far the margin's value is from turning, in multiples of what was asked for; rejects below one."""
    value, bound = evaluate(margin.value, measured), evaluate(margin.bound, measured)
    apart = _times_apart(value, bound) if margin.ratio else abs(value) / bound
    if apart < 1:
        raise Reject("margin", f"{value:.4g} where {bound:.4g} apart was asked for")
    return float(apart)


def _times_apart(ratio: float, factor: float) -> float:
    return abs(log(ratio)) / log(factor) if ratio > 0 and factor > 1 else 0.0


def apart(a: NDArray[np.float64], b: NDArray[np.float64]) -> float:
    """How far (m) the body that differs most between two outcomes (n, 7) is from itself."""
    return float(np.linalg.norm(a[:, :3] - b[:, :3], axis=1).max())


def distinct(poses: NDArray[np.float64], names: list[str], least: float) -> None:
    """Raise Reject if two of the outcomes (options, n, 7) are less than `least` (m) apart."""
    for i, j in combinations(range(len(names)), 2):
        gap = apart(poses[i], poses[j])
        if gap < least:
            raise Reject(
                "alike", f"{names[i]} and {names[j]}: {gap * 100:.1f} cm apart, {least * 100:.1f} cm asked for"
            )
