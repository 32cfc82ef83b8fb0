"""How systems choose: by the place of an option, otherwise when options are permuted, and which wrong outcome."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import pandas as pd

from wmspec.eval.report.intervals import Estimate, estimate, means, ratio, resampled
from wmspec.eval.report.replies import Replies
from wmspec.runtime.questions.model import FORESEEN

#: What a counterfactual may change, beside several at once. A change is written as its kind and what it changed.
BOTH, OTHER = "both", "other"


@dataclass(frozen=True)
class Position:
    """Of questions with `options` options, those whose true one is shown at `place` (from 0).

    The accuracy there, and how often the option at that place is chosen.
    """

    system: str
    options: int
    place: int
    accuracy: Estimate
    chosen: float


@dataclass(frozen=True)
class Flips:
    """Of questions that were asked with their options in several orders, how often two orders got different answers.

    `always` is the share of questions that are right in all orders.
    """

    task: str
    system: str
    flips: Estimate
    accuracy: float
    always: float


@dataclass(frozen=True)
class Mistaken:
    """Of wrong answers to a task of prediction, which share chose an outcome in which `changed` was otherwise.

    `offered` is the share of such outcomes among the wrong options of the same questions: what carelessness would
    choose.
    """

    task: str
    system: str
    changed: str
    chosen: float
    offered: float
    mistakes: int


def positions(replies: Replies) -> tuple[Position, ...]:
    """Accuracy and choices by place, for each number of options and system."""
    table = _shown(replies)
    return tuple(p for count, of_one in table.groupby("options") for p in _positions(int(str(count)), of_one))


def _shown(replies: Replies) -> pd.DataFrame:
    """Replies to questions with options, with the places as shown of the true option and of the one chosen (-1:

    none).
    """
    table = replies.table[(replies.table["options"] > 0) & replies.table["answer"].notna()]
    return pd.concat([_placed(of_one) for _, of_one in table.groupby("options")]) if len(table) else table


def _placed(table: pd.DataFrame) -> pd.DataFrame:
    """Of replies to questions with equally many options."""
    order = np.stack([np.asarray(o, dtype=int) for o in table["order"]])
    true, chosen = (order == table[c].fillna(-1).to_numpy(dtype=int)[:, None] for c in ("answer", "parsed"))
    return table.assign(true=true.argmax(1), chosen=np.where(chosen.any(1), chosen.argmax(1), -1))


def _positions(options: int, table: pd.DataFrame) -> Iterator[Position]:
    cells = table.groupby(["cluster", "system", "true"])["right"]
    right = cells.sum().unstack(["system", "true"], fill_value=0).sort_index(axis=1)
    count = cells.size().unstack(["system", "true"], fill_value=0).sort_index(axis=1)
    parts = right.to_numpy(dtype=float), count.to_numpy(dtype=float)
    drawn = ratio(*resampled(parts, ("place", options)))
    value = ratio(parts[0].sum(0), parts[1].sum(0))
    chosen = table[table["chosen"] >= 0].groupby("system")["chosen"].value_counts(normalize=True).to_dict()
    systems, places = (right.columns.get_level_values(level) for level in ("system", "true"))
    for j, (system, place) in enumerate(zip(systems, places, strict=True)):
        accuracy = estimate(value[j], drawn[:, j], int(parts[1][:, j].sum()), int((parts[1][:, j] > 0).sum()))
        yield Position(str(system), options, int(place), accuracy, float(chosen.get((system, place), 0.0)))


# ---------------------------------------------------------------- permutations


def flips(replies: Replies) -> tuple[Flips, ...]:
    """For each task and system that was asked in several orders, and for all tasks together ("")."""
    table = _shown(replies)
    key = ["id", "system", "sample"]
    several = table[table.groupby(key)["permutation"].transform("nunique") > 1]
    if several.empty:
        return ()
    whole = several.groupby(key, sort=True).agg(
        task=("task", "first"), cluster=("cluster", "first"), orders=("right", "size"), accuracy=("right", "mean"),
        always=("right", "min"),
    )  # fmt: skip
    # Two replies without an answer are not the same one: `groupby` leaves them out.
    alike = several.groupby([*key, "parsed"]).size()
    same = (alike * (alike - 1) / 2).groupby(level=[0, 1, 2]).sum().reindex(whole.index, fill_value=0)
    whole["flips"] = 1 - same / (whole["orders"] * (whole["orders"] - 1) / 2)
    pairs = whole.reset_index()
    return tuple(
        _flips(str(task), str(system), of_one)
        for (task, system), of_one in pd.concat([pairs.assign(task=""), pairs]).groupby(["task", "system"], sort=True)
    )


def _flips(task: str, system: str, pairs: pd.DataFrame) -> Flips:
    (estimate,), _ = means(pairs[["flips"]].to_numpy(), pairs["cluster"], ("flips", task))
    return Flips(task, system, estimate, float(pairs["accuracy"].mean()), float(pairs["always"].mean()))


# ---------------------------------------------------------------- counterfactuals


def mistaken(replies: Replies) -> tuple[Mistaken, ...]:
    """For each task whose wrong options are counterfactuals, and each system that chose some. Needs the dataset."""
    if replies.questions is None:
        return ()
    known = replies.questions.table
    foresees = known["kinds"].map(lambda kinds: not FORESEEN.isdisjoint(kinds))
    table = replies.table[replies.table["id"].isin(known.index[foresees]) & (replies.table["right"] == 0)]
    table = table[table["parsed"].notna()]
    changed = {str(name): tuple(map(change, changes)) for name, changes in known["changes"].items()}
    return tuple(
        m
        for (task, system), of_one in table.groupby(["task", "system"], sort=True)
        for m in _mistaken(str(task), str(system), of_one, changed)
    )


def _mistaken(task: str, system: str, wrong: pd.DataFrame, changed: dict[str, tuple[str, ...]]) -> Iterator[Mistaken]:
    chosen: dict[str, float] = {}
    offered: dict[str, float] = {}
    for name, place in zip(wrong["id"], wrong["parsed"], strict=True):
        those = [kind for kind in changed[name] if kind]
        for kind in those:
            offered[kind] = offered.get(kind, 0) + 1 / len(those)
        kind = changed[name][int(place)]
        chosen[kind] = chosen.get(kind, 0) + 1
    for kind in sorted(offered):
        yield Mistaken(task, system, kind, chosen.get(kind, 0) / len(wrong), offered[kind] / len(wrong), len(wrong))


def change(changes: str | None) -> str:
    """What an `option_change` says was changed: an action, a state, both, something other; "" for the truth.

    An action left out or added and another order of actions are changes of actions.
    """
    kinds = {part.split()[0] for part in (changes or "").split("; ") if part.strip()}
    names = {"action": "action", "without": "action", "order": "action", "add": "action", "state": "state"}
    labels = {names.get(kind, OTHER) for kind in kinds}
    return BOTH if len(labels) > 1 else next(iter(labels), "")
