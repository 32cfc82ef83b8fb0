"""Pairwise comparisons of systems on the questions that both answered, by the averages of the tables."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np
import pandas as pd

from wmspec.eval.report.intervals import CONFIDENCE, MIN_CLUSTERS, Estimate, Floats
from wmspec.eval.report.replies import Replies
from wmspec.eval.report.tables import Column


@dataclass(frozen=True)
class Comparison:
    """`difference` is the average of `first` minus that of `second`, over the questions that both were asked.

    Averages are those of the tables: the mean over dimensions of the mean of their tasks. `p` is the p-value of a
    t-test with errors robust to dependence in control groups, `corrected` the same after Holm's correction over all
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
    pairs = [_pair(kind, a, b, scores, main_questions) for a, b in combinations(replies.systems, 2)]
    return [pair for pair in pairs if pair is not None]


def _pair(kind: str, a: str, b: str, scores: pd.DataFrame, questions: pd.DataFrame) -> Comparison | None:
    both = scores[[a, b]].dropna()
    if both.empty:
        return None
    first, second = both[a].to_numpy(), both[b].to_numpy()
    difference, p = robust_mean(first - second, questions.loc[both.index])
    only = int(((first >= 0.5) & (second < 0.5)).sum()), int(((first < 0.5) & (second >= 0.5)).sum())
    return Comparison(kind, a, b, difference, p, None, *only)


def weights_in_average(questions: pd.DataFrame) -> Floats:
    """Return the weight of each question in the average: equal for dimensions, in these for tasks, then for questions.

    `questions` has `task` and `dimension`.
    """
    task = questions["task"]
    first = questions.drop_duplicates("task")
    by_task = {t: Column.of(t, d).dimension for t, d in zip(first["task"], first["dimension"], strict=True)}
    dimension, tasks = task.map(by_task), pd.Series(by_task).value_counts()
    each = dimension.nunique() * dimension.map(tasks) * task.map(task.value_counts())
    return np.asarray(1 / each.to_numpy(dtype=float))


def robust_mean(gaps: Floats, questions: pd.DataFrame) -> tuple[Estimate, float | None]:
    """Return the weighted mean of gaps with its interval, and the p-value.

    Both are missing if clusters are few. Tasks are strata: their means are known to differ, so deviations count within
    them (Cochran, Sampling Techniques, 1977, sections 5.4 and 9A.5).
    """
    from scipy.stats import t

    weights = weights_in_average(questions)
    mean = float(weights @ gaps)
    task, cluster = questions["task"], questions["cluster"]
    middle = pd.Series(gaps, questions.index).groupby(task).transform("mean").to_numpy()
    off = pd.Series(weights * (gaps - middle), questions.index).groupby([task, cluster]).sum()
    count = off.groupby(level=0).size()
    freedom = int(count.sum() - len(count))
    if (count < 2).any() or freedom < MIN_CLUSTERS - 1:
        return Estimate(mean, None, None, len(gaps)), None
    error = float(np.sqrt(((off**2).groupby(level=0).sum() * count / (count - 1)).sum()))
    if not error:
        return Estimate(mean, mean, mean, len(gaps)), 0.0 if mean else 1.0
    reach = float(t.ppf((1 + CONFIDENCE) / 2, freedom)) * error
    return Estimate(mean, mean - reach, mean + reach, len(gaps)), float(2 * t.sf(abs(mean) / error, freedom))


def _holm_corrected(pairs: list[Comparison]) -> list[Comparison]:
    from statsmodels.stats.multitest import multipletests

    tested = [i for i, pair in enumerate(pairs) if pair.p is not None]
    if not tested:
        return pairs
    holm = multipletests([pairs[i].p for i in tested], method="holm")[1]
    by_index = dict(zip(tested, map(float, holm), strict=True))
    return [replace(pair, corrected=by_index.get(i)) for i, pair in enumerate(pairs)]
