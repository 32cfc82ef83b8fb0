"""Pair accuracy: two instances that differ in one factor and have different answers count only if both are right.

What answers one of two without looking at what differs fails the other; see IntPhys 2 (Bordes et al., 2025) and MVP
(Krojer et al., 2025).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pandas as pd

from wmspec.eval.report.intervals import Estimate, Floats, estimate, ratio, resampled
from wmspec.eval.report.replies import Replies


@dataclass(frozen=True)
class Pair:
    """Of a task's pairs, `both` is the share of which both are right, `single` the accuracy on the questions in them.

    `chance` is what guessing yields.
    """

    task: str
    system: str
    both: Estimate
    single: float
    chance: float


def pairs(replies: Replies) -> tuple[Pair, ...]:
    """For each task with pairs, and each system that answered some. Needs the dataset."""
    if replies.questions is None:
        return ()
    return tuple(p for task in sorted(replies.asked["task"].unique()) for p in _task(replies, task))


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
    drawn = ratio(*resampled((right, count), ("pairs", task)))
    value = ratio(right.sum(0), count.sum(0))
    return [
        Pair(
            task,
            system,
            estimate(value[j], drawn[:, j], round(count[:, j].sum()), int((count[:, j] > 0).sum())),
            float(singles[system]),
            float(guess),
        )
        for j, system in enumerate(replies.systems)
        if count[:, j].any()
    ]


def _members(replies: Replies, task: str) -> pd.DataFrame:
    """Every question in every control group in which answers differ: `id`, `options`, `truth` and `group`."""
    assert replies.questions is not None
    asked = replies.asked[replies.asked["task"] == task]
    known = replies.questions.table.loc[asked.index]
    same = "/" + known["question"].astype(str) + "/" + known["engine"]
    keys = replies.questions.groups[task].loc[asked.index]
    parts = [
        pd.DataFrame({
            "id": asked.index,
            "options": asked["options"].to_numpy(),
            "truth": known["truth"].to_numpy(),
            "group": factor + "/" + keys[factor].astype(str) + same,
        })
        for factor in keys.columns
    ]  # fmt: skip
    table = pd.concat(parts, ignore_index=True) if parts else pd.DataFrame(columns=["id", "options", "truth", "group"])
    table = table[(table["options"] > 0) & (table["truth"] != "")]
    return table[table.groupby("group")["truth"].transform("nunique") > 1]


def _pairs(values: Floats, table: pd.DataFrame) -> Floats:
    """In each group, the sum over pairs with different truths of the products of their values: (groups, systems)."""
    frame = pd.DataFrame(values)
    group, truth = table["group"].to_numpy(), table["truth"].to_numpy()
    whole = frame.groupby(group).sum() ** 2
    same = (frame.groupby([group, truth]).sum() ** 2).groupby(level=0).sum()
    return np.asarray((whole - same).to_numpy() / 2)
