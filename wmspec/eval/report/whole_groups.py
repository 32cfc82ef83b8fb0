"""Accuracy on whole groups of possible and impossible episodes: all members must be answered correctly.

A quadruple in which every single picture is as often possible as not; see IntPhys (Riochet et al., 2018).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pandas as pd

from wmspec.eval.report.intervals import Estimate, mean_estimates
from wmspec.eval.report.replies import Replies

#: The answers of questions whether an episode is possible.
_ANSWERS = frozenset(("possible", "impossible"))


@dataclass(frozen=True)
class WholeGroup:
    """`whole` is the share of a task's groups with right answers only, `single` the accuracy on their questions.

    `members` is the mean number of questions in a group, `chance` the value of guessing.
    """

    task: str
    system: str
    whole: Estimate
    single: float
    members: float
    chance: float


def whole_groups(replies: Replies) -> tuple[WholeGroup, ...]:
    """Return the accuracy on whole groups of each task with possible episodes, by system. Requires the dataset."""
    if replies.questions is None:
        return ()
    known = replies.questions.table.loc[replies.main_questions.index]
    known = known[known["names"].map(lambda names: set(names) == _ANSWERS)]
    return tuple(made for task, table in known.groupby("task", sort=True) for made in _task(replies, str(task), table))


def _task(replies: Replies, task: str, table: pd.DataFrame) -> list[WholeGroup]:
    blocks = replies.table.drop_duplicates("id").set_index("id")["group"].loc[table.index]
    group = blocks + "/" + table["question"].astype(str) + "/" + table["engine"]
    varied = table.groupby(group)["truth"].transform("nunique") > 1
    group, scores = group[varied], replies.scores.loc[table.index[varied]]
    if scores.empty:
        return []
    whole = scores.groupby(group).prod(min_count=1).where(scores.notna().groupby(group).all())
    sizes = group.groupby(group).size()
    made = []
    for system in replies.systems:
        answered = whole[system].dropna()
        if answered.empty:
            continue
        (value,), _ = mean_estimates(answered.to_numpy()[:, None], answered.index, ("whole groups", task))
        own = sizes.loc[answered.index]
        single = float(scores[system][group.isin(answered.index)].mean())
        made.append(WholeGroup(task, system, value, single, float(own.mean()), float(np.mean(0.5**own))))
    return made
