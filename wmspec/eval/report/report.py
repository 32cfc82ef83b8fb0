"""All analyses of a set of results."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TypeVar, get_args

import numpy as np

from wmspec.dataset.build.reader import DatasetReader
from wmspec.eval.models.causes import Cause, causes
from wmspec.eval.models.splits import DEFAULT_SPLITS, Splits
from wmspec.eval.replies import Outcome
from wmspec.eval.report.choices import Flips, Mistakes, Position, flips, mistakes, positions
from wmspec.eval.report.compare import Comparison, comparisons
from wmspec.eval.report.curves import Curve, curves
from wmspec.eval.report.detection import Detection, detections
from wmspec.eval.report.entanglement import Entanglement, entanglement
from wmspec.eval.report.films import FilmScores, films
from wmspec.eval.report.filtered import FilteredAccuracy, MissedAccuracy, filtered_accuracies, missed_accuracies
from wmspec.eval.report.items import Items, items
from wmspec.eval.report.pairs import Pair, pairs
from wmspec.eval.report.preferences import Preference, preferences
from wmspec.eval.report.replies import PEOPLE, Replies, read
from wmspec.eval.report.seen import SeenAccuracy, seen_accuracies
from wmspec.eval.report.tables import Table, tables
from wmspec.eval.report.whole_groups import WholeGroup, whole_groups

T = TypeVar("T")


@dataclass(frozen=True)
class Account:
    """The requests of a system by outcome, tokens and cost, and the causes of questions without an answer.

    `cost` is in the currency of the prices given to `wmspec evaluate`, None if unknown.
    """

    system: str
    questions: int
    replies: int
    answered: int
    unparsed: int
    truncated: int
    refused: int
    error: int
    tokens_in: int | None
    tokens_out: int | None
    cost: float | None
    causes: tuple[Cause, ...] = ()


@dataclass(frozen=True)
class Report:
    """The content of a report.

    `raters` is the number of people, `dataset` the name of the dataset, if given. `narrow` are the tasks whose
    intervals are over instances, because they have too few control groups.
    """

    dataset: str
    raters: int
    narrow: tuple[str, ...]
    accounts: tuple[Account, ...]
    tables: tuple[Table, ...]
    comparisons: tuple[Comparison, ...]
    pairs: tuple[Pair, ...]
    whole_groups: tuple[WholeGroup, ...]
    flips: tuple[Flips, ...]
    positions: tuple[Position, ...]
    mistaken: tuple[Mistakes, ...]
    entanglement: tuple[Entanglement, ...]
    curves: tuple[Curve, ...]
    detections: tuple[Detection, ...]
    preferences: tuple[Preference, ...]
    filtered: tuple[FilteredAccuracy, ...]
    missed: tuple[MissedAccuracy, ...]
    items: Items | None
    seen: tuple[SeenAccuracy, ...] = ()
    films: tuple[FilmScores, ...] = ()

    @property
    def systems(self) -> tuple[str, ...]:
        """The systems: best average first, people last."""
        best: dict[str, list[float]] = {}
        for table in self.tables:
            for line in table.lines:
                best.setdefault(line.system, []).append(line.average.value)
        return tuple(sorted(best, key=lambda s: (s == PEOPLE, -sum(best[s]) / len(best[s]), s)))


def report(
    results: list[Path],
    dataset: Path | None,
    progress: Callable[[str, int], None],
    names: Mapping[str, str] | None = None,
    splits: Splits = DEFAULT_SPLITS,
) -> Report:
    """Read results and run every analysis that they and the dataset permit. `progress` is called after each.

    `names` are display names by model; the hold-outs of `splits` and of the dataset separate seen and unseen questions.

    Raises WmsError if a file cannot be read, or files do not match.
    """
    read_replies = read(results, dataset, names)
    if dataset is not None:
        splits = splits.of_dataset(DatasetReader.open(dataset))
    return analyse(read_replies, dataset.resolve().name if dataset else "", progress, splits)


def analyse(
    replies: Replies, dataset: str, progress: Callable[[str, int], None], splits: Splits = DEFAULT_SPLITS
) -> Report:
    """Return every analysis of replies."""

    def step(name: str, analysis: Callable[[Replies], T]) -> T:
        made = analysis(replies)
        progress(name, 1)
        return made

    return Report(
        dataset=dataset,
        raters=replies.raters["model"].nunique(),
        narrow=replies.narrow,
        accounts=step("accounts", accounts),
        tables=step("tables", tables),
        comparisons=step("comparisons", comparisons),
        pairs=step("pairs", pairs),
        whole_groups=step("whole groups", whole_groups),
        flips=step("flips", flips),
        positions=step("positions", positions),
        mistaken=step("mistakes", mistakes),
        entanglement=step("entanglement", entanglement),
        curves=step("curves", curves),
        detections=step("detections", detections),
        preferences=step("preferences", preferences),
        filtered=step("filtered", filtered_accuracies),
        missed=step("missed", missed_accuracies),
        items=step("items", items),
        seen=seen_accuracies(replies, splits),
        films=step("films", films),
    )


#: Number of calls of `progress`.
STEPS = 15


def accounts(replies: Replies) -> tuple[Account, ...]:
    """Return the requests of every system."""
    return tuple(_account(replies, system) for system in sorted(replies.systems))


def _account(replies: Replies, system: str) -> Account:
    table = replies.table[replies.table["system"] == system]
    status = table["status"].value_counts()

    def total(column: str) -> float | None:
        known = table[column].dropna()
        return float(known.sum()) if len(known) else None

    tokens = [None if (n := total(c)) is None else int(n) for c in ("tokens_in", "tokens_out")]
    counts = {outcome: int(status.get(outcome, 0)) for outcome in get_args(Outcome)}
    rows = table[["id", "status", "text", "error", "finish_reason"]].replace({np.nan: None})
    lost = causes({str(name): value for name, value in row.items()} for row in rows.to_dict("records"))
    return Account(
        system, table["id"].nunique(), len(table), **counts, tokens_in=tokens[0], tokens_out=tokens[1],
        cost=total("cost"), causes=lost,
    )  # fmt: skip
