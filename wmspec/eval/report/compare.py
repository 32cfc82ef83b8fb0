"""Pairwise comparisons of systems on the questions that both answered."""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from itertools import combinations

import numpy as np
import pandas as pd

from wmspec.eval.report.intervals import CONFIDENCE, MIN_CLUSTERS, Estimate, Floats
from wmspec.eval.report.replies import Replies


@dataclass(frozen=True)
class Comparison:
    """`difference` is the accuracy of `first` minus that of `second`, each question with equal weight.

    `p` is the p-value of a t-test with cluster-robust errors, `corrected` the same after Holm's correction over all
    comparisons of the kind. `first_only` and `second_only` count the questions that only one system answers correctly.
    """

    kind: str
    first: str
    second: str
    difference: Estimate
    p: float | None
    corrected: float | None
    first_only: int
    second_only: int


def comparisons(replies: Replies) -> tuple[Comparison, ...]:
    """Return the comparison of every pair of systems, for each kind of task."""
    kind = replies.main_questions["dimension"].str.split(".").str[0]
    return tuple(c for k in sorted(kind.unique()) for c in _holm_corrected(_of_kind(replies, k, kind == k)))


def _of_kind(replies: Replies, kind: str, chosen: pd.Series[bool]) -> list[Comparison]:
    main_questions = replies.main_questions[chosen]
    scores = replies.scores.loc[main_questions.index]
    pairs = [_pair(kind, a, b, scores, main_questions["cluster"]) for a, b in combinations(replies.systems, 2)]
    return [pair for pair in pairs if pair is not None]


def _pair(kind: str, a: str, b: str, scores: pd.DataFrame, cluster: pd.Series[str]) -> Comparison | None:
    both = scores[[a, b]].dropna()
    if both.empty:
        return None
    first, second = both[a].to_numpy(), both[b].to_numpy()
    difference, p = _robust_mean(first - second, cluster.loc[both.index])
    only = int(((first >= 0.5) & (second < 0.5)).sum()), int(((first < 0.5) & (second >= 0.5)).sum())
    return Comparison(kind, a, b, difference, p, None, *only)


def _robust_mean(gaps: Floats, cluster: pd.Series[str]) -> tuple[Estimate, float | None]:
    """Return the mean of gaps with its interval, and the p-value; without interval if clusters are few or gaps are
    constant.
    """
    import statsmodels.api as sm

    mean, codes = float(gaps.mean()), pd.factorize(cluster)[0]
    if codes.max() + 1 < MIN_CLUSTERS:
        return Estimate(mean, None, None, len(gaps)), None
    if not gaps.any():
        return Estimate(mean, mean, mean, len(gaps)), 1.0
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # perfect fit if all gaps are equal
        fit = sm.OLS(gaps, np.ones(len(gaps))).fit(cov_type="cluster", cov_kwds={"groups": codes}, use_t=True)
        low, high = fit.conf_int(1 - CONFIDENCE)[0]
        return Estimate(mean, float(low), float(high), len(gaps)), float(np.nan_to_num(fit.pvalues[0]))


def _holm_corrected(pairs: list[Comparison]) -> list[Comparison]:
    from statsmodels.stats.multitest import multipletests

    tested = [i for i, pair in enumerate(pairs) if pair.p is not None]
    if not tested:
        return pairs
    holm = multipletests([pairs[i].p for i in tested], method="holm")[1]
    by_index = dict(zip(tested, map(float, holm), strict=True))
    return [
        Comparison(c.kind, c.first, c.second, c.difference, c.p, by_index.get(i), c.first_only, c.second_only)
        for i, c in enumerate(pairs)
    ]
