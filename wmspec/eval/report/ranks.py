"""Rank agreement: whether two datasets, such as WM-ABench and its rebuilt tasks, rank the same models alike."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pandas as pd

from wmspec.eval.report.compare import weights_in_average
from wmspec.eval.report.intervals import DRAWS, MIN_CLUSTERS, Estimate, Floats, cluster_sums, estimate, resample_sums
from wmspec.eval.report.replies import BASELINES, PEOPLE, Replies

#: Minimum number of common models.
MIN_MODELS = 3


@dataclass(frozen=True)
class RankAgreement:
    """Rank correlations of the averages of `models` in two sets of results, of one kind of task ('' for all).

    `spearman` and `kendall` (τ-b) have intervals by a bootstrap over the control groups of both datasets: how far they
    depend on the questions, not on the choice of models.
    """

    kind: str
    models: tuple[str, ...]
    first: tuple[float, ...]
    second: tuple[float, ...]
    spearman: Estimate
    kendall: Estimate


def rank_agreement(first: Replies, second: Replies) -> tuple[RankAgreement, ...]:
    """Return the agreement over all questions, and for each kind of task that both have, of at least three models."""
    models = [s for s in first.systems if s in second.systems and s not in (*BASELINES, PEOPLE)]
    if len(models) < MIN_MODELS:
        return ()
    kinds = [replies.main_questions["dimension"].str.split(".").str[0] for replies in (first, second)]
    both = sorted(set(kinds[0]) & set(kinds[1]))
    chosen = ["", *(both if len(set(kinds[0]) | set(kinds[1])) > 1 else ())]
    return tuple(_agreement(kind, models, (first, second), kinds) for kind in chosen)


def _agreement(
    kind: str, models: list[str], both: tuple[Replies, Replies], kinds: list[pd.Series[str]]
) -> RankAgreement:
    averages, draws, questions, clusters = [], [], 0, []
    for number, (replies, kind_of) in enumerate(zip(both, kinds, strict=True)):
        about = replies.main_questions if not kind else replies.main_questions[kind_of == kind]
        scores = replies.scores.loc[about.index, models].dropna()
        value, drawn, count = _averages(about.loc[scores.index], scores.to_numpy(), (kind, number))
        averages.append(value)
        draws.append(drawn)
        questions += len(scores)
        clusters.append(count)
    pairs = [(_spearman, "spearman"), (_kendall, "kendall")]
    found = {
        name: estimate(
            measure(averages[0], averages[1]),
            np.array([measure(a, b) for a, b in zip(*draws, strict=True)]),
            questions,
            min(clusters),
        )
        for measure, name in pairs
    }
    return RankAgreement(kind, tuple(models), tuple(averages[0]), tuple(averages[1]), **found)


def _averages(about: pd.DataFrame, scores: Floats, key: object) -> tuple[Floats, Floats, int]:
    """Return the averages (m,) of scores (n, m) as in the tables, their draws (d, m), and the number of clusters."""
    if not len(about):
        return np.full(scores.shape[1], np.nan), np.full((DRAWS, scores.shape[1]), np.nan), 0
    weights = weights_in_average(about)
    drawn = np.zeros((DRAWS, scores.shape[1]))
    clusters = 0
    for task, places in about.reset_index().groupby("task").groups.items():
        rows = np.asarray(places)
        total, count = cluster_sums(scores[rows], about["cluster"].to_numpy()[rows])
        above, below = resample_sums((total, count), ("ranks", key, task))
        drawn += weights[rows].sum() * above / np.maximum(below, 1)
        clusters += len(total)
    return weights @ scores, drawn, clusters if clusters >= MIN_CLUSTERS else 0


def _spearman(first: Floats, second: Floats) -> float:
    from scipy.stats import rankdata

    a, b = (rankdata(v) - (len(v) + 1) / 2 for v in (first, second))
    below = np.sqrt((a @ a) * (b @ b))
    return float(a @ b / below) if below else float("nan")


def _kendall(first: Floats, second: Floats) -> float:
    a, b = (np.sign(v[:, None] - v[None])[np.triu_indices(len(v), 1)] for v in (first, second))
    below = np.sqrt((a @ a) * (b @ b))
    return float(a @ b / below) if below else float("nan")
