"""Choices of systems: by option position, under permutation of options, and among wrong outcomes."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import pandas as pd

from wmspec.eval.report.intervals import Estimate, mean_estimates, share_estimates
from wmspec.eval.report.replies import Replies
from wmspec.runtime.questions.model import HYPOTHETICAL

#: Labels for changes of several kinds, and for other kinds. A change is written as its kind and its object.
SEVERAL_KINDS, OTHER_KIND = "both", "other"


@dataclass(frozen=True)
class Position:
    """Accuracy of questions with `options` options whose true one is shown at `place` (from 0).

    `chosen` is the share of choices of that position.
    """

    system: str
    options: int
    place: int
    accuracy: Estimate
    chosen: float


@dataclass(frozen=True)
class Flips:
    """The share of pairs of option orders with different answers, over questions asked in several orders.

    `always` is the share of questions that are right in all orders.
    """

    task: str
    system: str
    flips: Estimate
    accuracy: float
    always: float


@dataclass(frozen=True)
class Mistakes:
    """The share of wrong answers to a prediction task that chose an outcome with `changed` altered.

    `offered` is the share of such outcomes among the wrong options of the same questions, as expected from guessing.
    """

    task: str
    system: str
    changed: str
    chosen: float
    offered: float
    mistakes: int


def positions(replies: Replies) -> tuple[Position, ...]:
    """Return accuracy and choices by position, for each number of options and system."""
    table = _shown_places(replies)
    return tuple(p for count, of_one in table.groupby("options") for p in _positions(int(str(count)), of_one))


def _shown_places(replies: Replies) -> pd.DataFrame:
    """Return replies to questions with options, with the positions as shown of the true and chosen option.

    The chosen position is -1 if there is none.
    """
    table = replies.table[(replies.table["options"] > 0) & replies.table["answer"].notna()]
    return pd.concat([_positions_of(of_one) for _, of_one in table.groupby("options")]) if len(table) else table


def _positions_of(table: pd.DataFrame) -> pd.DataFrame:
    """Return positions for replies to questions with equally many options."""
    order = np.stack([np.asarray(o, dtype=int) for o in table["order"]])
    true, chosen = (order == table[c].fillna(-1).to_numpy(dtype=int)[:, None] for c in ("answer", "parsed"))
    return table.assign(true=true.argmax(1), chosen=np.where(chosen.any(1), chosen.argmax(1), -1))


def _positions(options: int, table: pd.DataFrame) -> Iterator[Position]:
    cells = table.groupby(["cluster", "system", "true"])["right"]
    right = cells.sum().unstack(["system", "true"], fill_value=0).sort_index(axis=1)
    count = cells.size().unstack(["system", "true"], fill_value=0).sort_index(axis=1)
    accuracies, _ = share_estimates(right.to_numpy(dtype=float), count.to_numpy(dtype=float), ("place", options))
    chosen = table[table["chosen"] >= 0].groupby("system")["chosen"].value_counts(normalize=True).to_dict()
    systems, places = (right.columns.get_level_values(level) for level in ("system", "true"))
    for accuracy, system, place in zip(accuracies, systems, places, strict=True):
        yield Position(str(system), options, int(place), accuracy, float(chosen.get((system, place), 0.0)))


# ---------------------------------------------------------------- permutations


def flips(replies: Replies) -> tuple[Flips, ...]:
    """Return the flips of each task and system with several orders, and of all tasks together ('')."""
    table = _shown_places(replies)
    key = ["id", "system", "sample"]
    several = table[table.groupby(key)["permutation"].transform("nunique") > 1]
    if several.empty:
        return ()
    whole = several.groupby(key, sort=True).agg(
        task=("task", "first"), cluster=("cluster", "first"), orders=("right", "size"), accuracy=("right", "mean"),
        always=("right", "min"),
    )  # fmt: skip
    # Two unparsed replies do not count as equal: `groupby` drops NaN.
    alike = several.groupby([*key, "parsed"]).size()
    same = (alike * (alike - 1) / 2).groupby(level=[0, 1, 2]).sum().reindex(whole.index, fill_value=0)
    whole["flips"] = 1 - same / (whole["orders"] * (whole["orders"] - 1) / 2)
    pairs = whole.reset_index()
    return tuple(
        _flips(str(task), str(system), of_one)
        for (task, system), of_one in pd.concat([pairs.assign(task=""), pairs]).groupby(["task", "system"], sort=True)
    )


def _flips(task: str, system: str, pairs: pd.DataFrame) -> Flips:
    (estimate,), _ = mean_estimates(pairs[["flips"]].to_numpy(), pairs["cluster"], ("flips", task))
    return Flips(task, system, estimate, float(pairs["accuracy"].mean()), float(pairs["always"].mean()))


# ---------------------------------------------------------------- counterfactuals


def mistakes(replies: Replies) -> tuple[Mistakes, ...]:
    """Return the mistakes of each system in tasks with counterfactual options. Requires the dataset."""
    if replies.questions is None:
        return ()
    known = replies.questions.table
    foresees = known["kinds"].map(lambda kinds: not HYPOTHETICAL.isdisjoint(kinds))
    table = replies.table[replies.table["id"].isin(known.index[foresees]) & (replies.table["right"] == 0)]
    table = table[table["parsed"].notna()]
    changed = {str(name): tuple(map(kind_of_change, changes)) for name, changes in known["changes"].items()}
    return tuple(
        m
        for (task, system), of_one in table.groupby(["task", "system"], sort=True)
        for m in _task_mistakes(str(task), str(system), of_one, changed)
    )


def _task_mistakes(
    task: str, system: str, wrong: pd.DataFrame, changed: dict[str, tuple[str, ...]]
) -> Iterator[Mistakes]:
    chosen: dict[str, float] = {}
    offered: dict[str, float] = {}
    for name, place in zip(wrong["id"], wrong["parsed"], strict=True):
        those = [kind for kind in changed[name] if kind]
        for kind in those:
            offered[kind] = offered.get(kind, 0) + 1 / len(those)
        kind = changed[name][int(place)]
        chosen[kind] = chosen.get(kind, 0) + 1
    for kind in sorted(offered):
        yield Mistakes(task, system, kind, chosen.get(kind, 0) / len(wrong), offered[kind] / len(wrong), len(wrong))


def kind_of_change(changes: str | None) -> str:
    """Return the kind of an `option_change`: an action, a state, both, other; '' for the truth.

    Actions omitted, added or reordered are changes of actions.
    """
    kinds = {part.split()[0] for part in (changes or "").split("; ") if part.strip()}
    names = {"action": "action", "without": "action", "order": "action", "add": "action", "state": "state"}
    labels = {names.get(kind, OTHER_KIND) for kind in kinds}
    return SEVERAL_KINDS if len(labels) > 1 else next(iter(labels), "")
