"""Every analysis of a set of results, one after the other."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TypeVar

from wmspec.eval.report.choices import Flips, Mistaken, Position, flips, mistaken, positions
from wmspec.eval.report.compare import Comparison, comparisons
from wmspec.eval.report.curves import Curve, curves
from wmspec.eval.report.entanglement import Entangled, entanglement
from wmspec.eval.report.filtered import Filtered, filtered
from wmspec.eval.report.items import Items, items
from wmspec.eval.report.pairs import Pair, pairs
from wmspec.eval.report.replies import PEOPLE, Replies, read
from wmspec.eval.report.tables import Table, tables

T = TypeVar("T")


@dataclass(frozen=True)
class Account:
    """What became of a system's requests: replies with an answer, without one, refused; requests that failed.

    `cost` is in the currency of the prices given to `wmspec evaluate`, None where it is not known.
    """

    system: str
    questions: int
    replies: int
    unparsed: int
    refused: int
    failed: int
    tokens_in: int | None
    tokens_out: int | None
    cost: float | None


@dataclass(frozen=True)
class Report:
    """Everything that a report tells.

    `raters` is how many people answered, `dataset` the name of the dataset, if given. `narrow` are the tasks whose
    intervals are over instances, because they have too few control groups.
    """

    dataset: str
    raters: int
    narrow: tuple[str, ...]
    accounts: tuple[Account, ...]
    tables: tuple[Table, ...]
    comparisons: tuple[Comparison, ...]
    pairs: tuple[Pair, ...]
    flips: tuple[Flips, ...]
    positions: tuple[Position, ...]
    mistaken: tuple[Mistaken, ...]
    entanglement: tuple[Entangled, ...]
    curves: tuple[Curve, ...]
    filtered: tuple[Filtered, ...]
    items: Items | None

    @property
    def systems(self) -> tuple[str, ...]:
        """Who answered: the best on average first, people last."""
        best: dict[str, list[float]] = {}
        for table in self.tables:
            for line in table.lines:
                best.setdefault(line.system, []).append(line.average.value)
        return tuple(sorted(best, key=lambda s: (s == PEOPLE, -sum(best[s]) / len(best[s]), s)))


def report(results: list[Path], dataset: Path | None, progress: Callable[[str, int], None]) -> Report:
    """Read results and do every analysis that they and the dataset allow. `progress` is told of each that is done.

    Raises WmsError if something cannot be read, or does not belong together.
    """
    return analyse(read(results, dataset), dataset.resolve().name if dataset else "", progress)


def analyse(replies: Replies, dataset: str, progress: Callable[[str, int], None]) -> Report:
    """Every analysis of replies."""

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
        flips=step("flips", flips),
        positions=step("positions", positions),
        mistaken=step("mistakes", mistaken),
        entanglement=step("entanglement", entanglement),
        curves=step("curves", curves),
        filtered=step("filtered", filtered),
        items=step("items", items),
    )


#: How many steps `progress` is told of.
STEPS = 11


def accounts(replies: Replies) -> tuple[Account, ...]:
    """What became of every system's requests."""
    systems = sorted({*replies.systems, *replies.failed})
    return tuple(_account(replies, system) for system in systems)


def _account(replies: Replies, system: str) -> Account:
    table = replies.table[replies.table["system"] == system]
    status = table["status"].value_counts()

    def total(column: str) -> float | None:
        known = table[column].dropna()
        return float(known.sum()) if len(known) else None

    tokens = [None if (n := total(c)) is None else int(n) for c in ("tokens_in", "tokens_out")]
    return Account(
        system, table["id"].nunique(), len(table), int(status.get("unparsed", 0)), int(status.get("refused", 0)),
        replies.failed.get(system, 0), tokens[0], tokens[1], total("cost"),
    )  # fmt: skip
