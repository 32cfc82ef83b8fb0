"""Pairwise comparisons of systems on the questions that both answered, by the averages of the tables."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np
import pandas as pd
from numpy.typing import NDArray

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
    questions = replies.main_questions[chosen]
    scores = replies.scores.loc[questions.index].to_numpy()
    strata: dict[bytes, Strata] = {}  # most pairs of systems answered the same questions
    pairs = []
    for (i, a), (j, b) in combinations(enumerate(replies.systems), 2):
        both = ~np.isnan(scores[:, [i, j]]).any(axis=1)
        if both.any():
            if (key := both.tobytes()) not in strata:
                strata[key] = Strata.of(questions[both])
            pairs.append(_pair(kind, a, b, scores[both, i], scores[both, j], strata[key]))
    return pairs


def _pair(kind: str, a: str, b: str, first: Floats, second: Floats, strata: Strata) -> Comparison:
    difference, p = strata.robust_mean(first - second)
    only = int(((first >= 0.5) & (second < 0.5)).sum()), int(((first < 0.5) & (second >= 0.5)).sum())
    return Comparison(kind, a, b, difference, p, None, *only)


def weights_in_average(questions: pd.DataFrame, by_kind: bool = False) -> Floats:
    """Return the weight of each question in the average: equal for dimensions, in these for tasks, then for questions.

    `questions` has `task` and `dimension`. With `by_kind`, kinds of tasks have equal weights, and dimensions in these.
    """
    task = questions["task"]
    first = questions.drop_duplicates("task").set_index("task")["dimension"]
    kinds = first.str.split(".").str[0] if by_kind else first.map(lambda _: "")
    dimensions = kinds + "/" + [Column.of(str(t), d).dimension for t, d in first.items()]
    in_kind, in_dimension = dimensions.groupby(kinds).nunique(), dimensions.value_counts()
    of_task = kinds.nunique() * kinds.map(in_kind) * dimensions.map(in_dimension)
    each = task.map(of_task) * task.map(task.value_counts())
    return np.asarray(1 / each.to_numpy(dtype=float))


@dataclass(frozen=True)
class Strata:
    """The weights of questions in an average, their tasks, and their control groups in tasks, as numbers.

    `task_of` has the task of each group.
    """

    weights: Floats
    task: NDArray[np.intp]
    group: NDArray[np.intp]
    task_of: NDArray[np.intp]

    @staticmethod
    def of(questions: pd.DataFrame) -> Strata:
        """Return the strata of questions with `task`, `dimension` and `cluster`."""
        task = np.asarray(pd.factorize(questions["task"])[0], np.intp)
        group = np.asarray(questions.groupby([task, "cluster"]).ngroup(), np.intp)
        task_of = np.zeros(group.max() + 1, np.intp)
        task_of[group] = task
        return Strata(weights_in_average(questions), task, group, task_of)

    def robust_mean(self, gaps: Floats) -> tuple[Estimate, float | None]:
        """Return the weighted mean of gaps with its interval, and the p-value.

        Both are missing if clusters are few. Tasks are strata: their means are known to differ, so deviations count
        within them (Cochran, Sampling Techniques, 1977, sections 5.4 and 9A.5).
        """
        from scipy.stats import t

        mean = float(self.weights @ gaps)
        middle = np.bincount(self.task, gaps) / np.bincount(self.task)
        off = np.bincount(self.group, self.weights * (gaps - middle[self.task]))
        count = np.bincount(self.task_of)
        freedom = int(count.sum() - len(count))
        if (count < 2).any() or freedom < MIN_CLUSTERS - 1:
            return Estimate(mean, None, None, len(gaps)), None
        error = float(np.sqrt((np.bincount(self.task_of, off**2) * count / (count - 1)).sum()))
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
