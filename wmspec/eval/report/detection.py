"""Signal detection in same/different questions: hits, false alarms, d′ and criterion.

A bias to one answer changes accuracy on "same" and "different" items in opposite directions, but not d′. Rates have the
log-linear correction (Hautus, 1995), so that d′ is finite.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import pandas as pd

from wmspec.eval.report.curves import strength
from wmspec.eval.report.intervals import (
    Estimate,
    Floats,
    cluster_sums,
    estimate,
    ratio,
    resample_sums,
    spread_at_bounds,
)
from wmspec.eval.report.replies import Replies


@dataclass(frozen=True)
class Detection:
    """How well a system detects a difference in a same/different question.

    `hits` is the share of "different" items answered so, `alarms` that of "same" items. `sensitivity` is d′, the
    distance of the two in standard deviations. A positive `criterion` is a bias to "same". `difference` is the tier of
    the "different" items; None for all tiers. "Same" items have no tier and count in each.
    """

    task: str
    question: str
    system: str
    difference: float | None
    hits: Estimate
    alarms: Estimate
    sensitivity: Estimate
    criterion: Estimate


def detections(replies: Replies) -> tuple[Detection, ...]:
    """Return the result of each same/different question and each system. Requires the dataset.

    A question is same/different if it has two options, and one of them is true exactly where `difference` is none: 0,
    or a ratio of 1.
    """
    if replies.questions is None:
        return ()
    known = replies.questions.table.loc[replies.main_questions.index]
    parts = known[known["quantity"] != ""].groupby(["task", "question_name"], sort=True)
    return tuple(d for (task, name), of_one in parts for d in _question(replies, str(task), str(name), of_one))


def _question(replies: Replies, task: str, name: str, known: pd.DataFrame) -> Iterator[Detection]:
    tiers, _ = strength(str(known["quantity"].iloc[0]), known["difference"].to_numpy(dtype=float))
    same = np.isnan(tiers)
    answers = known["truth"].to_numpy()
    if not (known["options"] == 2).all() or same.all() or not same.any():
        return
    if len(set(answers[same])) != 1 or len(set(answers[~same])) != 1 or answers[same][0] == answers[~same][0]:
        return
    tiers = np.round(tiers, 6)
    clusters = replies.about.loc[known.index, "cluster"].to_numpy()
    for system in replies.systems:
        right = replies.scores.loc[known.index, system].to_numpy(dtype=float)
        for tier in (None, *np.unique(tiers[~same])):
            different = ~same if tier is None else tiers == tier
            yes = np.column_stack([np.where(different, right, np.nan), np.where(same, 1 - right, np.nan)])
            if not np.isnan(yes).all(axis=0).any():
                yield _detection((task, name, system, None if tier is None else float(tier)), yes, clusters)


def _detection(key: tuple[str, str, str, float | None], yes: Floats, clusters: Floats) -> Detection:
    """Return the result for the answers "different" (n, 2): to different and to same items, NaN elsewhere."""
    said, count = cluster_sums(yes, clusters)
    drawn_said, drawn_count = resample_sums((said, count), ("detection", key))
    value, rated = ratio(said.sum(0), count.sum(0)), (count > 0).sum(0)
    drawn = spread_at_bounds(value, ratio(drawn_said, drawn_count), rated, key)
    signal, drawn_signal = _signal(said.sum(0), count.sum(0)), _signal(drawn_said, drawn_count)
    questions = count.sum(0).astype(int)
    groups = int((count > 0).any(axis=1).sum())
    return Detection(
        *key,
        *(estimate(value[j], drawn[:, j], int(questions[j]), int(rated[j])) for j in range(2)),
        *(estimate(signal[j], drawn_signal[:, j], int(questions.sum()), groups) for j in range(2)),
    )


def _signal(said: Floats, count: Floats) -> Floats:
    """Return d′ and criterion (..., 2) of answers "different" and numbers of items (..., 2)."""
    from scipy.special import ndtri

    z = ndtri((said + 0.5) / (count + 1))
    return np.stack([z[..., 0] - z[..., 1], -(z[..., 0] + z[..., 1]) / 2], axis=-1)
