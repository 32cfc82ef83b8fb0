"""Signed table of choices: which colour, shape, side or outcome a system chooses in place of the truth when it errs."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import pandas as pd

from wmspec.eval.report.intervals import Estimate, Floats, cluster_sums, estimate, ratio, resample_sums
from wmspec.eval.report.replies import Replies

#: Minimum number of errors, and maximum number of levels of a property.
MIN_ERRORS, MAX_LEVELS = 10, 12


@dataclass(frozen=True)
class Preference:
    """How much a system prefers a level of a property in its errors.

    `chosen` is the share of errors that choose the level, `true` the share whose truth has it, and `bias` the
    difference (-1 to 1): positive if the level replaces others more often than others replace it. Errors in which both
    options have the same level do not count.
    """

    task: str
    system: str
    dimension: str
    level: str
    chosen: float
    true: float
    bias: Estimate


def preferences(replies: Replies) -> tuple[Preference, ...]:
    """Return the preferences of each system in each task, where options name levels. Requires the dataset."""
    if replies.questions is None:
        return ()
    table = replies.table[
        (replies.table["right"] == 0) & replies.table["parsed"].notna() & (replies.table["options"] > 0)
    ]
    table = table[table["answer"].notna()]
    levels = {str(id): found for id, found in replies.questions.table["levels"].items()}
    return tuple(
        p
        for (task, system), of_one in table.groupby(["task", "system"], sort=True)
        for p in _preferences(str(task), str(system), of_one, levels)
    )


def _preferences(
    task: str, system: str, errors: pd.DataFrame, levels: dict[str, tuple[dict[str, str], ...]]
) -> Iterator[Preference]:
    moved: dict[str, list[tuple[str, str, str]]] = defaultdict(list)
    for id, place, answer, cluster in zip(
        errors["id"], errors["parsed"], errors["answer"], errors["cluster"], strict=True
    ):
        options = levels[str(id)]
        chosen, true = options[int(place)], options[int(answer)]
        for dimension in chosen.keys() & true.keys():
            if chosen[dimension] != true[dimension]:
                moved[dimension].append((chosen[dimension], true[dimension], str(cluster)))
    for dimension, moves in sorted(moved.items()):
        names = sorted({level for move in moves for level in move[:2]})
        if len(moves) >= MIN_ERRORS and len(names) <= MAX_LEVELS:
            yield from _levels((task, system, dimension), names, moves)


def _levels(key: tuple[str, str, str], names: list[str], moves: list[tuple[str, str, str]]) -> Iterator[Preference]:
    chosen, true = (np.array([[move[part] == n for n in names] for move in moves], dtype=float) for part in (0, 1))
    cluster = [move[2] for move in moves]
    bias: Floats = chosen - true
    total, count = cluster_sums(bias, cluster)
    drawn = ratio(*resample_sums((total, count), ("preference", *key)))
    for j, name in enumerate(names):
        value = estimate(float(bias[:, j].mean()), drawn[:, j], len(moves), len(total))
        yield Preference(*key, name, float(chosen[:, j].mean()), float(true[:, j].mean()), value)
