"""s-RE, the standardized relative entanglement of the paper: dependence of accuracy on irrelevant factors.

For a factor with N levels, p_i the accuracy at level i and p̄ the mean of the p_i, it is the mean of |1 − p_i / p̄|
(Gao et al., 2025, section 5). A system that ignores the factor has a positive value by chance. Therefore the values
with shuffled levels are reported as a null band. Intervals come from a bootstrap over control groups, shifted by its
bias, since resampling adds differences between levels.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from wmspec.eval.report.intervals import CONFIDENCE, MIN_CLUSTERS, Floats, ratio, resample_sums, seeded_generator
from wmspec.eval.report.questions import Questions
from wmspec.eval.report.replies import Replies
from wmspec.lang.check.tables.vocabulary import FACTOR_DIMENSIONS, WORDS

#: Number of shuffles; maximum number of levels of a factor; minimum number of questions at each level.
SHUFFLES, MAX_LEVELS, MIN_QUESTIONS = 300, 12, 5
#: Number of bootstrap draws.
BOOTSTRAPS = 500
#: Relative difference from which stimulus differences are distinct; Cramér's V from which answers depend on a factor.
MIN_STEP, MIN_ASSOCIATION = 0.1, 0.3

#: The dimensions of factors: the paper's five, then surroundings and all else.
DIMENSIONS = tuple(FACTOR_DIMENSIONS)


@dataclass(frozen=True)
class Entanglement:
    """s-RE of a task by one factor: `value` with its interval `low` to `high`, None if there are few control groups.

    With shuffled levels, `mean` is the mean, and `least` to `bound` the null band, from the 5 % to the 95 % quantile.
    `p` is the share of shuffles with at least this value. `dimension` is the one that the dataset records, or one that
    follows from the values, or ''. If `probed`, the answer or the stimulus difference depends on the factor; then
    accuracy may depend on it too.
    """

    task: str
    question: str
    factor: str
    dimension: str
    probed: bool
    system: str
    levels: int
    questions: int
    value: float
    low: float | None
    high: float | None
    mean: float
    least: float
    bound: float
    p: float


def entanglement(replies: Replies) -> tuple[Entanglement, ...]:
    """Return s-RE for each task, question, factor or nuisance with few levels, and system. Requires the dataset."""
    if replies.questions is None:
        return ()
    questions = replies.main_questions
    parts = questions.groupby(["task", "question_name"], sort=True)
    return tuple(e for (task, name), of_one in parts for e in _question(replies, str(task), str(name), of_one))


def _question(replies: Replies, task: str, name: str, questions: pd.DataFrame) -> Iterator[Entanglement]:
    assert replies.questions is not None
    varied = replies.questions.varied[task].loc[questions.index]
    everything = questions
    for factor in varied.columns:
        questions = everything[_has_level(varied[factor])]
        codes, levels = pd.factorize(varied.loc[questions.index, factor].astype(str), sort=True)
        scores = replies.scores.loc[questions.index].to_numpy()
        if 2 <= len(levels) <= MAX_LEVELS and np.bincount(codes).min() >= MIN_QUESTIONS:
            facet = replies.questions.about.get(task, {}).get(factor) or dimension_of_values(varied[factor])
            about = _depends_on_factor(replies.questions, task, factor, questions.index)
            yield from _factor(replies, (task, name, factor, facet, about), codes, scores, questions)


def _has_level(values: pd.Series[str]) -> pd.Series[bool]:
    """Whether each question counts: all, but for looks of objects only those with a frequent look."""
    if not str(values.name).startswith("object "):
        return pd.Series(True, values.index)
    return values.notna() & (values.groupby(values).transform("size").reindex(values.index) >= MIN_QUESTIONS)


def _factor(
    replies: Replies,
    key: tuple[str, str, str, str, bool],
    codes: NDArray[np.intp],
    scores: Floats,
    questions: pd.DataFrame,
) -> Iterator[Entanglement]:
    value = relative_entanglement(codes, scores)
    shuffled = _shuffled_entanglement(codes, scores, questions["index"].to_numpy(), key)
    low, high = _intervals(codes, scores, questions["cluster"].to_numpy(), value, key)
    for j, system in enumerate(replies.systems):
        drawn = shuffled[:, j][~np.isnan(shuffled[:, j])]
        if np.isnan(value[j]) or not len(drawn):
            continue
        as_much = (1 + int((drawn >= value[j] - 1e-12).sum())) / (1 + len(drawn))
        least, bound = map(float, np.quantile(drawn, [0.05, 0.95]))
        known = not np.isnan(low[j])
        yield Entanglement(
            *key, system, int(codes.max()) + 1, int((~np.isnan(scores[:, j])).sum()), float(value[j]),
            float(low[j]) if known else None, float(high[j]) if known else None,
            float(drawn.mean()), least, bound, as_much,
        )  # fmt: skip


def _intervals(
    codes: NDArray[np.intp], scores: Floats, cluster: NDArray[np.object_], value: Floats, key: object
) -> tuple[Floats, Floats]:
    """Return both ends (m,) of the 95 % interval of s-RE (m,), NaN with few clusters."""
    _, which = np.unique(cluster.astype(str), return_inverse=True)
    levels, clusters = int(codes.max()) + 1, int(which.max()) + 1
    if clusters < MIN_CLUSTERS:
        return np.full_like(value, np.nan), np.full_like(value, np.nan)
    right = np.zeros((clusters, levels, scores.shape[1]))
    count = np.zeros_like(right)
    np.add.at(right, (which, codes), np.nan_to_num(scores))
    np.add.at(count, (which, codes), ~np.isnan(scores))
    p = ratio(*resample_sums((right, count), ("entanglement", *np.atleast_1d(np.asarray(key, dtype=str))), BOOTSTRAPS))
    middle = np.nanmean(p, axis=1, keepdims=True) if p.size else p
    drawn = ratio(np.nanmean(abs(middle - p), axis=1), middle[:, 0])
    shift = np.nanmean(drawn, axis=0) - value
    ends = np.nanquantile(drawn, [(1 - CONFIDENCE) / 2, (1 + CONFIDENCE) / 2], axis=0) - shift
    return np.clip(ends[0], 0, value), np.maximum(ends[1], value)


def _depends_on_factor(questions: Questions, task: str, factor: str, ids: pd.Index[str]) -> bool:
    """Whether the answer or the difference changes with this factor alone.

    Without such pairs of questions, whether answers are associated with the factor's levels.
    """
    if factor not in questions.groups[task]:
        return False  # nuisances have no groups
    known = questions.table.loc[ids]
    strong = known["difference"].abs()
    alone = pd.DataFrame({"truth": known["truth"], "strength": strong}).groupby(
        [questions.groups[task].loc[ids, factor].astype(str), known["question"], known["engine"]]
    )
    apart = alone["strength"].max() - alone["strength"].min()
    if (alone["truth"].nunique() > 1).any() or (apart > MIN_STEP * strong.abs().mean()).any():
        return True
    if (alone.size() > 1).any() or known["truth"].nunique() < 2:
        return False
    return _association(known["truth"], questions.varied[task].loc[ids, factor].astype(str)) > MIN_ASSOCIATION


def _association(first: pd.Series[str], second: pd.Series[str]) -> float:
    """Return Cramér's V of two text columns."""
    from scipy.stats.contingency import association

    table = pd.crosstab(first, second).to_numpy()
    return float(association(table)) if min(table.shape) > 1 else 0.0


def relative_entanglement(codes: NDArray[np.intp], scores: Floats) -> Floats:
    """Return s-RE of scores (n, m) by levels (n,): (m,), NaN if a level has no scores or nothing is right."""
    at = np.zeros((int(codes.max()) + 1, len(codes)))
    at[codes, np.arange(len(codes))] = 1
    p = ratio(at @ np.nan_to_num(scores), at @ (~np.isnan(scores)).astype(float))
    middle = p.mean(0)
    off = abs(middle - p).mean(0)
    return ratio(off, middle)


def _shuffled_entanglement(codes: NDArray[np.intp], scores: Floats, instance: NDArray[np.int64], key: object) -> Floats:
    """Return s-RE (SHUFFLES, m) with shuffled levels; the rows of an instance in several engines keep one level."""
    _, first, which = np.unique(instance, return_index=True, return_inverse=True)
    generator = seeded_generator("shuffle", *np.atleast_1d(np.asarray(key, dtype=str)))
    return np.stack(
        [relative_entanglement(generator.permutation(codes[first])[which], scores) for _ in range(SHUFFLES)]
    )


def dimension_of_values(values: pd.Series[str]) -> str:
    """Return the dimension of a factor whose values are words for colors, shapes or materials; '' for others."""
    levels = {str(v) for v in values.unique()}
    return next((name for name in ("color", "shape", "material") if levels <= set(WORDS[name])), "")
