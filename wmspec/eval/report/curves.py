"""Psychometric curves: accuracy as a function of the stimulus difference, and thresholds.

Accuracy at a difference x is γ + (1 − γ − λ) σ(β (x − α)). Guessing γ is chance, the lapse rate λ is at most 6 %
(Wichmann and Hill, 2001), and α is the threshold, half-way between guessing and the maximum. Fitted by maximum
likelihood on a grid, refined with scipy. Intervals of α come from a cluster bootstrap with fits on the grid.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from wmspec.eval.report.intervals import CONFIDENCE, MIN_CLUSTERS, Floats, cluster_sums, resample_sums
from wmspec.eval.report.replies import Replies

#: Maximum lapse rate; number of bootstrap draws; minimum number of differences for a curve; number of points shown.
MAX_LAPSE, CURVE_DRAWS, MIN_LEVELS, MAX_POINTS = 0.06, 1000, 3, 8
#: Maximum number of distinct differences; beyond it neighbours are merged.
MAX_LEVELS = 40
#: No threshold is reported if the p-value of a flat curve exceeds this.
MAX_FLAT_P = 0.05


@dataclass(frozen=True)
class Curve:
    """A system's accuracy on a task as a function of the stimulus difference, on a linear or log `scale`.

    `points` are (difference, accuracy, questions), with neighbours merged. `alpha`, `beta`, `lapse` are the fit on that
    axis (the logarithm to base 2 if `log`), None without one. `threshold` is α as a difference in `unit`, None outside
    the range shown; `low` and `high` are its interval, None where it exceeds the range. `flat` is the p-value of a flat
    curve.
    """

    task: str
    question: str
    quantity: str
    unit: str
    scale: str
    system: str
    chance: float
    points: tuple[tuple[float, float, int], ...]
    flat: float | None
    alpha: float | None
    beta: float | None
    lapse: float | None
    threshold: float | None
    low: float | None
    high: float | None

    def at(self, x: Floats) -> Floats:
        """Return the fitted accuracy at differences."""
        from scipy.special import expit

        assert self.alpha is not None
        assert self.beta is not None
        assert self.lapse is not None
        along = np.log2(x) if self.scale == "log" else x
        return np.asarray(self.chance + (1 - self.chance - self.lapse) * expit(self.beta * (along - self.alpha)))


@dataclass(frozen=True)
class Fit:
    """α, β and λ on the axis from 0 (smallest difference) to 1 (largest), and the log-likelihood."""

    alpha: float
    beta: float
    lapse: float
    likelihood: float


def curves(replies: Replies) -> tuple[Curve, ...]:
    """Return a curve for each question with a stimulus difference, and each system. Requires the dataset.

    A difference counts by its size, a ratio by its distance from 1. Questions without a difference ("neither is
    faster") are excluded, since they test something else.
    """
    if replies.questions is None:
        return ()
    known = replies.questions.table.loc[replies.main_questions.index]
    known = known[(known["quantity"] != "") & (known["options"] > 0)]
    keys = ["task", "question_name", "quantity", "unit"]
    parts = ((tuple(map(str, key)), of_one) for key, of_one in known.groupby(keys, sort=True))
    return tuple(
        curve
        for (task, name, quantity, unit), of_one in parts
        for curve in _curves(replies, (task, name, quantity, unit), of_one)
    )


def strength(quantity: str, value: Floats) -> tuple[Floats, str]:
    """Return the strengths of differences, NaN for none, and the scale: log for ratios, measured from 1."""
    if " / " in quantity:
        with np.errstate(divide="ignore"):
            ratios = np.exp2(abs(np.log2(abs(value))))
        return np.where((ratios > 1 + 1e-6) & np.isfinite(ratios), ratios, np.nan), "log"
    return np.where(abs(value) > 1e-9, abs(value), np.nan), "linear"


def _curves(replies: Replies, key: tuple[str, str, str, str], known: pd.DataFrame) -> Iterator[Curve]:
    x, scale = strength(key[2], known["difference"].to_numpy(dtype=float))
    known, x = known[~np.isnan(x)], _merge_neighbours(np.round(x[~np.isnan(x)], 6))
    levels = np.unique(x)
    if len(levels) < 2:
        return
    about = replies.about.loc[known.index]
    chance = float((1 / about["options"]).mean())
    which = np.searchsorted(levels, x)
    for system in replies.systems:
        right = replies.scores.loc[known.index, system].to_numpy()
        there = ~np.isnan(right)
        if there.any():
            cells = np.full((len(right), len(levels)), np.nan)
            cells[np.arange(len(right)), which] = right
            yield _curve(
                key, scale, system, chance, levels, cluster_sums(cells[there], about["cluster"].to_numpy()[there])
            )


def _curve(
    key: tuple[str, str, str, str], scale: str, system: str, chance: float, levels: Floats, parts: tuple[Floats, Floats]
) -> Curve:
    right, count = parts[0].sum(0), parts[1].sum(0)
    shown = _points(levels, right, count)
    has_questions = count > 0
    along = np.log2(levels) if scale == "log" else levels
    least, span = along[0], along[-1] - along[0]
    place = (along - least) / span
    empty = Curve(*key, scale, system, chance, shown, *(None,) * 7)
    if has_questions.sum() < MIN_LEVELS or len(parts[0]) < MIN_CLUSTERS:
        return empty
    grid = CurveGrid(place[has_questions], chance)
    best = grid.fit(right[has_questions], count[has_questions])
    flat = _flat(best, right, count)
    alpha, beta = least + best.alpha * span, best.beta / span
    fitted = (flat, float(alpha), float(beta), best.lapse)
    if flat > MAX_FLAT_P:
        return Curve(*key, scale, system, chance, shown, *fitted, None, None, None)
    drawn = grid.thresholds(
        *(part[:, has_questions] for part in resample_sums(parts, ("curve", key, system), CURVE_DRAWS))
    )
    low, high = (float(q) for q in np.quantile(drawn, [(1 - CONFIDENCE) / 2, (1 + CONFIDENCE) / 2], method="nearest"))

    def back(share: float) -> float | None:
        """A threshold on the axis from 0 to 1 as a difference; None if it is outside of what was shown."""
        value = least + share * span
        return (float(np.exp2(value)) if scale == "log" else float(value)) if 0 <= share <= 1 else None

    return Curve(*key, scale, system, chance, shown, *fitted, back(best.alpha), back(low), back(high))


def _points(levels: Floats, right: Floats, count: Floats) -> tuple[tuple[float, float, int], ...]:
    """Return at most POINTS points with about equal numbers of questions."""
    total = np.cumsum(count)
    bins = np.minimum((total - count / 2) / total[-1] * MAX_POINTS, MAX_POINTS - 1).astype(int)
    bins = np.arange(len(levels)) if len(levels) <= MAX_POINTS else bins
    parts = [(levels[bins == b], right[bins == b], count[bins == b]) for b in np.unique(bins)]
    return tuple(
        (float(np.average(x, weights=n)), float(k.sum() / n.sum()), int(n.sum())) for x, k, n in parts if n.sum()
    )


def _merge_neighbours(x: Floats) -> Floats:
    """Return differences, replaced by the mean of their neighbours if there are more than MOST_LEVELS."""
    from scipy.stats import rankdata

    if len(np.unique(x)) <= MAX_LEVELS:
        return x
    bins = np.minimum(rankdata(x) / len(x) * MAX_LEVELS, MAX_LEVELS - 1).astype(int)
    return np.asarray((np.bincount(bins, x) / np.maximum(np.bincount(bins), 1))[bins])


class CurveGrid:
    """Candidate curves over differences `x` (l,), from 0 to 1, with guessing at `chance`: rising, falling, flat and
    steep.
    """

    def __init__(self, x: Floats, chance: float) -> None:
        alpha = np.linspace(-1, 2, 151)
        beta = np.outer([1, -1], np.geomspace(0.5, 60, 12)).ravel()
        mesh = np.meshgrid(alpha, beta, np.linspace(0, MAX_LAPSE, 3), indexing="ij")
        self._x, self._chance = x, chance
        self._curves = np.stack([part.ravel() for part in mesh], axis=1)
        p = self._at(self._curves.T[:, :, None])
        self._right, self._wrong = np.log(p), np.log1p(-p)

    def _at(self, q: Floats) -> Floats:
        from scipy.special import expit

        p = self._chance + (1 - self._chance - q[2]) * expit(q[1] * (self._x - q[0]))
        return np.asarray(np.clip(p, 1e-9, 1 - 1e-9))

    def fit(self, right: Floats, count: Floats) -> Fit:
        """Return the most likely curve through `right` of `count` (l,) questions."""
        from scipy.optimize import minimize

        def surprise(q: Floats) -> float:
            p = self._at(q)
            return float(-(right * np.log(p) + (count - right) * np.log1p(-p)).sum())

        start = self._curves[self._best(right[None], count[None])[0]]
        steep = (0.5, 60) if start[1] > 0 else (-60, -0.5)
        solution = minimize(surprise, start, method="L-BFGS-B", bounds=[(-1, 2), steep, (0, MAX_LAPSE)])
        alpha, beta, lapse = map(float, solution.x)
        return Fit(alpha, beta, lapse, float(-solution.fun))

    def thresholds(self, right: Floats, count: Floats) -> Floats:
        """Return α of the most likely curve of every draw (d, l)."""
        return np.asarray(self._curves[self._best(right, count), 0])

    def _best(self, right: Floats, count: Floats) -> NDArray[np.intp]:
        likely = right @ self._right.T + (count - right) @ self._wrong.T
        return np.asarray(likely.argmax(1))


def _flat(best: Fit, right: Floats, count: Floats) -> float:
    """Return the p-value of the likelihood-ratio test against constant accuracy (two more parameters)."""
    from scipy.special import xlogy
    from scipy.stats import chi2

    k, n = right.sum(), count.sum()
    constant = xlogy(k, k / n) + xlogy(n - k, 1 - k / n)
    return float(chi2.sf(max(0.0, 2 * (best.likelihood - constant)), 2))
