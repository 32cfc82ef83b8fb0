"""Compositional generalization: accuracy on levels that training saw, and on held-out levels and pairs of levels."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import pandas as pd

from wmspec.eval.models.splits import Splits
from wmspec.eval.report.intervals import Estimate, cluster_sums, estimate, share_estimates
from wmspec.eval.report.replies import Replies


@dataclass(frozen=True)
class SeenAccuracy:
    """A system's accuracy in a task ('' for all) on questions without and with a hold-out, and the loss `gap`."""

    task: str
    system: str
    seen: Estimate
    unseen: Estimate
    gap: Estimate


def seen_accuracies(replies: Replies, splits: Splits) -> tuple[SeenAccuracy, ...]:
    """Return the result of each task with both kinds of questions, and of all of these together, for each system.

    Requires the dataset; empty without hold-outs.
    """
    if replies.questions is None or not splits.hold_out:
        return ()
    main = replies.main_questions
    unseen = pd.concat([_unseen(replies, str(task), of_one.index, splits) for task, of_one in main.groupby("task")])
    both = unseen.groupby(main["task"].reindex(unseen.index)).nunique()
    tasks = [str(task) for task, kinds in both.items() if kinds == 2]
    chosen = [(task, main.index[main["task"] == task]) for task in tasks]
    if len(tasks) > 1:
        chosen.append(("", main.index[main["task"].isin(tasks)]))
    return tuple(found for task, ids in chosen for found in _accuracies(replies, task, ids, unseen.reindex(ids)))


def _unseen(replies: Replies, task: str, ids: pd.Index[str], splits: Splits) -> pd.Series[bool]:
    assert replies.questions is not None
    levels = replies.questions.levels_of(task).loc[ids]
    rows = levels.to_dict("records")
    return pd.Series([splits.is_unseen(task, {str(k): v for k, v in row.items()}) for row in rows], ids)


def _accuracies(replies: Replies, task: str, ids: pd.Index[str], unseen: pd.Series[bool]) -> Iterator[SeenAccuracy]:
    cluster = replies.about.loc[ids, "cluster"].to_numpy()
    for system in replies.systems:
        right = replies.scores.loc[ids, system].to_numpy(dtype=float)
        values = np.column_stack([np.where(unseen, np.nan, right), np.where(unseen, right, np.nan)])
        if np.isnan(values).all(0).any():
            continue
        total, count = cluster_sums(values, cluster)
        (seen, held_out), drawn = share_estimates(total, count, ("seen", task, system))
        groups = int((count > 0).sum(0).min())
        gap = estimate(seen.value - held_out.value, drawn[:, 0] - drawn[:, 1], int(count.sum()), groups)
        yield SeenAccuracy(task, system, seen, held_out, gap)
