"""Pair accuracy: two instances that differ in one factor and in their answers count only if both are right.

A system that answers one of two without regard to the difference fails the other; see IntPhys 2 (Bordes et al., 2025)
and MVP (Krojer et al., 2025).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pandas as pd

from wmspec.eval.report.intervals import Estimate, Floats, share_estimates
from wmspec.eval.report.replies import Replies


@dataclass(frozen=True)
class Pair:
    """`both` is the share of a task's pairs with two right answers, `single` the accuracy on their questions.

    `chance` is the pair accuracy of guessing.
    """

    task: str
    system: str
    both: Estimate
    single: float
    chance: float


def pairs(replies: Replies) -> tuple[Pair, ...]:
    """Return the pair accuracy of each task with pairs, and each system. Requires the dataset."""
    if replies.questions is None:
        return ()
    return tuple(p for task in sorted(replies.main_questions["task"].unique()) for p in _task(replies, task))


def _task(replies: Replies, task: str) -> list[Pair]:
    table = _members(replies, task)
    if table.empty:
        return []
    scores = replies.scores.loc[table["id"]].to_numpy()
    right, count = _pairs(np.nan_to_num(scores), table), _pairs((~np.isnan(scores)).astype(float), table)
    singles = replies.scores.loc[table["id"].unique()].mean()
    guess = _pairs(1 / table[["options"]].to_numpy(dtype=float), table).sum() / max(
        1.0, _pairs(np.ones((len(table), 1)), table).sum()
    )
    both, _ = share_estimates(right, count, ("pairs", task))
    return [
        Pair(task, system, both[j], float(singles[system]), float(guess))
        for j, system in enumerate(replies.systems)
        if count[:, j].any()
    ]


def _members(replies: Replies, task: str) -> pd.DataFrame:
    """Return every question in every control group with differing answers: `id`, `options`, `truth` and `group`."""
    assert replies.questions is not None
    main_questions = replies.main_questions[replies.main_questions["task"] == task]
    known = replies.questions.table.loc[main_questions.index]
    same = "/" + known["question"].astype(str) + "/" + known["engine"]
    keys = replies.questions.groups[task].loc[main_questions.index]
    parts = [
        pd.DataFrame({
            "id": main_questions.index,
            "options": main_questions["options"].to_numpy(),
            "truth": known["truth"].to_numpy(),
            "group": factor + "/" + keys[factor].astype(str) + same,
        })
        for factor in keys.columns
    ]  # fmt: skip
    table = pd.concat(parts, ignore_index=True) if parts else pd.DataFrame(columns=["id", "options", "truth", "group"])
    table = table[(table["options"] > 0) & (table["truth"] != "")]
    return table[table.groupby("group")["truth"].transform("nunique") > 1]


def _pairs(values: Floats, table: pd.DataFrame) -> Floats:
    """Return, for each group, the sum over pairs with different truths of the products of values: (groups, systems)."""
    frame = pd.DataFrame(values)
    group, truth = table["group"].to_numpy(), table["truth"].to_numpy()
    whole = frame.groupby(group).sum() ** 2
    same = (frame.groupby([group, truth]).sum() ** 2).groupby(level=0).sum()
    return np.asarray((whole - same).to_numpy() / 2)
