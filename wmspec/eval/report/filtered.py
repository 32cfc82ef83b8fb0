"""Perception-filtered prediction: does a system foresee better what it has seen rightly?

In tasks of prediction, questions about what is seen are asked of the same episode (does anything move, which colour,
which shape is it?). Accuracy is taken on all predictions, and on those of whose episode all such questions were
answered rightly: by the system itself, and, as the paper does, by all models.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from wmspec.eval.report.intervals import Estimate, Floats, estimate, ratio, resampled, sums
from wmspec.eval.report.replies import Replies

#: Whose perception a prediction is filtered by.
ITS_OWN, EVERYONES = "its own", "all models'"


@dataclass(frozen=True)
class Filtered:
    """A system's accuracy on all predictions of a task, on those perceived rightly `by`, and the gain Δ to these.

    `kept` is the share of predictions that are left.
    """

    task: str
    system: str
    by: str
    everything: Estimate
    perceived: Estimate
    gain: Estimate
    kept: float


def filtered(replies: Replies) -> tuple[Filtered, ...]:
    """For each task of prediction with queries, and each system that answered them. Needs the dataset."""
    if replies.questions is None or not replies.about["query"].any():
        return ()
    queried = sorted(replies.about.loc[replies.about["query"], "task"].unique())
    return tuple(f for task in queried for f in _task(replies, task))


def _task(replies: Replies, task: str) -> Iterator[Filtered]:
    about = replies.about[replies.about["task"] == task]
    predictions = about[~about["query"]]
    seen = _seen(replies, about).reindex(_episode(predictions)).reset_index(drop=True)
    scores = replies.scores.loc[predictions.index].reset_index(drop=True)
    everyone = seen[list(replies.models)].min(axis=1, skipna=False) if replies.models else pd.Series(np.nan, seen.index)
    cluster = predictions["cluster"].to_numpy()
    for system in replies.systems:
        for by, perceived in ((ITS_OWN, seen[system]), (EVERYONES, everyone)):
            told = scores[system].notna() & perceived.notna()
            if told.any():
                key = (task, system, by)
                yield _filtered(
                    key,
                    scores[system][told].to_numpy(dtype=float),
                    np.asarray(perceived[told], dtype=np.float64),
                    cluster[told.to_numpy()],
                )


def _episode(about: pd.DataFrame) -> pd.Series[str]:
    return about["index"].astype(str) + "/" + about["engine"]


def _seen(replies: Replies, about: pd.DataFrame) -> pd.DataFrame:
    """Of every episode, for each system: 1 if it answered all queries rightly, 0 if not, NaN if one was not asked."""
    queries = about[about["query"]]
    right = (replies.scores.loc[queries.index] >= 1).where(replies.scores.loc[queries.index].notna()).astype(float)
    return right.groupby(_episode(queries)).min()


def _filtered(key: tuple[str, str, str], right: Floats, seen: Floats, cluster: NDArray[Any]) -> Filtered:
    values = np.stack([right, np.ones_like(right), right * seen, seen], axis=1)
    parts, _ = sums(values, cluster)
    drawn = resampled((parts,), key)[0]
    whole, those = ratio(drawn[:, 0], drawn[:, 1]), ratio(drawn[:, 2], drawn[:, 3])
    total = parts.sum(0)
    everything, perceived = float(total[0] / total[1]), float(ratio(total[2], total[3]))
    count, kept, clusters = int(total[1]), int(total[3]), len(parts)
    clusters_kept = int((parts[:, 3] > 0).sum())
    return Filtered(
        *key,
        estimate(everything, whole, count, clusters),
        estimate(perceived, those, kept, clusters_kept),
        estimate(perceived - everything, those - whole, kept, clusters_kept),
        kept / count,
    )
