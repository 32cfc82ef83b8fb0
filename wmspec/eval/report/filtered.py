"""Perception-filtered prediction: accuracy of predictions given that state and action were perceived.

Prediction tasks have companion questions about the same episode: on the state and the action that distinguish the
options (which ball is heavier, does it move slowly or fast?). Accuracy is taken over all predictions, and over those of
episodes whose companion questions were all answered correctly. The latter is judged by the system's own answers and, as
in the paper, by those of all models. A further analysis takes the predictions of episodes with one companion question
answered wrongly: it shows which perception a prediction depends on.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

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

#: The system whose perception filters the predictions.
OWN_PERCEPTION, ALL_MODELS = "its own", "all models'"


@dataclass(frozen=True)
class FilteredAccuracy:
    """A system's accuracy on all predictions of a task, on those perceived correctly `by`, and the gain Δ.

    `kept` is the share of predictions that remain.
    """

    task: str
    system: str
    by: str
    everything: Estimate
    perceived: Estimate
    gain: Estimate
    kept: float


@dataclass(frozen=True)
class MissedAccuracy:
    """A system's accuracy on all predictions of a task, on those whose companion question `missed` it answered wrongly,
    and the gain Δ.

    `share` is the share of predictions with this question answered wrongly.
    """

    task: str
    system: str
    missed: str
    everything: Estimate
    accuracy: Estimate
    gain: Estimate
    share: float


def filtered_accuracies(replies: Replies) -> tuple[FilteredAccuracy, ...]:
    """Return the result of each prediction task with companion questions and each system. Requires the dataset."""
    return tuple(f for task in _queried_tasks(replies) for f in _task(replies, task))


def missed_accuracies(replies: Replies) -> tuple[MissedAccuracy, ...]:
    """Return the result of each companion question that a system answers wrongly. Requires the dataset."""
    return tuple(m for task in _queried_tasks(replies) for m in _missed(replies, task))


def _queried_tasks(replies: Replies) -> list[str]:
    if replies.questions is None:
        return []
    return sorted(replies.about.loc[replies.about["query"], "task"].unique())


def _task(replies: Replies, task: str) -> Iterator[FilteredAccuracy]:
    about = replies.about[replies.about["task"] == task]
    predictions = about[~about["query"]]
    seen = _perceived(replies, about).reindex(_episode(predictions)).reset_index(drop=True)
    scores = replies.scores.loc[predictions.index].reset_index(drop=True)
    everyone = seen[list(replies.models)].min(axis=1, skipna=False) if replies.models else pd.Series(np.nan, seen.index)
    cluster = predictions["cluster"].to_numpy()
    for system in replies.systems:
        for by, perceived in ((OWN_PERCEPTION, seen[system]), (ALL_MODELS, everyone)):
            valid = scores[system].notna() & perceived.notna()
            if valid.any():
                key = (task, system, by)
                yield _filtered_accuracy(
                    key,
                    scores[system][valid].to_numpy(dtype=float),
                    np.asarray(perceived[valid], dtype=np.float64),
                    cluster[valid.to_numpy()],
                )


def _missed(replies: Replies, task: str) -> Iterator[MissedAccuracy]:
    about = replies.about[replies.about["task"] == task]
    predictions = about[~about["query"]]
    scores = replies.scores.loc[predictions.index].reset_index(drop=True)
    for name in sorted(about.loc[about["query"], "question_name"].unique()):
        rows = about[~about["query"] | (about["question_name"] == name)]
        seen = _perceived(replies, rows).reindex(_episode(predictions)).reset_index(drop=True)
        for system in replies.systems:
            valid = scores[system].notna() & seen[system].notna()
            missed = 1.0 - np.asarray(seen[system][valid], dtype=np.float64)
            if missed.any():
                right, cluster = scores[system][valid].to_numpy(dtype=float), predictions["cluster"].to_numpy()
                found = _filtered_accuracy((task, system, name), right, missed, cluster[valid.to_numpy()])
                yield MissedAccuracy(task, system, name, found.everything, found.perceived, found.gain, found.kept)


def _episode(about: pd.DataFrame) -> pd.Series[str]:
    return about["index"].astype(str) + "/" + about["engine"]


def _perceived(replies: Replies, about: pd.DataFrame) -> pd.DataFrame:
    """Return, for each episode and system: 1 if all companion questions are right, 0 if not, NaN if one is missing."""
    queries = about[about["query"]]
    right = (replies.scores.loc[queries.index] >= 1).where(replies.scores.loc[queries.index].notna()).astype(float)
    return right.groupby(_episode(queries)).min()


def _filtered_accuracy(
    key: tuple[str, str, str], right: Floats, seen: Floats, cluster: NDArray[Any]
) -> FilteredAccuracy:
    values = np.stack([right, np.ones_like(right), right * seen, seen], axis=1)
    parts, _ = cluster_sums(values, cluster)
    drawn = resample_sums((parts,), key)[0]
    total = parts.sum(0)
    value, clusters_of = ratio(total[[0, 2]], total[[1, 3]]), (parts[:, [1, 3]] > 0).sum(0)
    both = spread_at_bounds(value, ratio(drawn[:, [0, 2]], drawn[:, [1, 3]]), clusters_of, key)
    whole, those = both.T
    everything, perceived = map(float, value)
    count, kept = int(total[1]), int(total[3])
    clusters, clusters_kept = map(int, clusters_of)
    return FilteredAccuracy(
        *key,
        estimate(everything, whole, count, clusters),
        estimate(perceived, those, kept, clusters_kept),
        estimate(perceived - everything, those - whole, kept, clusters_kept),
        kept / count,
    )
