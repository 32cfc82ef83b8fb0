"""Splits of a dataset for training: by control groups, with levels and pairs of levels that training never sees."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

from wmspec.core.diagnostics import WmsError, suggestion
from wmspec.dataset.build.reader import DatasetReader
from wmspec.dataset.build.splits import DEFAULT_SHARES, TEST, parse_shares, split_of_group

_LEVEL = re.compile(r"\s*([a-z][a-z0-9_]*)\s*=\s*([^,=]+?)\s*")


@dataclass(frozen=True)
class Splits:
    """Shares of splits in percent, and hold-outs: levels by factor that never occur together in training.

    A control group is in one split, which depends on its name alone: another dataset of the same design and seed has
    the same splits. Questions with a hold-out in a group for training or validation are in no split. `declared` are the
    hold-outs of the specs by task, which `holdouts` add to. `whole` is the split of all questions of a dataset that was
    generated as one. `units` has, by task, the block that stands for each block in groups that are balanced together.
    """

    shares: Mapping[str, int] = field(default_factory=lambda: dict(DEFAULT_SHARES))
    holdouts: tuple[Mapping[str, str], ...] = ()
    declared: Mapping[str, tuple[Mapping[str, str], ...]] = field(default_factory=dict)
    whole: str = ""
    units: Mapping[str, Mapping[int, int]] = field(default_factory=dict)

    @classmethod
    def parse(cls, shares: str, holdouts: Sequence[str]) -> Splits:
        """Return splits from `train=80,validation=10,test=10` and hold-outs such as `shape=cone,color=blue`.

        Raises WmsError for anything else.
        """
        return cls(parse_shares(shares), tuple(map(_holdout, holdouts)))

    def of_dataset(self, dataset: DatasetReader) -> Splits:
        """Return the splits with what a dataset records: hold-outs of its specs, and its split if it is one.

        Raises WmsError if no task of the dataset has the factors of a hold-out, or if it is a split of other shares.
        """
        self._check(dataset)
        tasks = dataset.manifest["tasks"]
        declared = {
            name: tuple({factor: _text(level) for factor, level in out.items()} for out in task["holdouts"])
            for name, task in tasks.items()
            if task.get("holdouts")
        }
        units = {
            name: {block: min(batch) for batch in task.get("balance_batches", ()) for block in batch}
            for name, task in tasks.items()
        }
        split = dataset.manifest.get("split")
        if split and self.shares not in (split["shares"], DEFAULT_SHARES):
            raise WmsError(f"--shares: the dataset is the split `{split['name']}`, of shares {_words(split['shares'])}")
        shares = split["shares"] if split else self.shares
        return replace(self, shares=shares, declared=declared, units=units, whole=split["name"] if split else "")

    def _check(self, dataset: DatasetReader) -> None:
        known = {c.split(".", 1)[1] for task in dataset.tasks for c in dataset.columns(task) if c.startswith("factor.")}
        for holdout in self.holdouts:
            for name in holdout:
                if name not in known:
                    hint = suggestion(name, sorted(known))
                    raise WmsError(f"--holdout {name}: no task has this factor; {hint}".rstrip("; "))

    @property
    def hold_out(self) -> bool:
        """Whether there are hold-outs."""
        return bool(self.holdouts or self.declared)

    def of_block(self, task: str, block: int) -> str:
        """Return the split of a control group."""
        if self.whole:
            return self.whole
        return split_of_group(f"{task}/{self.units.get(task, {}).get(block, block)}", self.shares)

    def is_unseen(self, task: str, factors: Mapping[str, Any]) -> bool:
        """Whether levels by factor of a question of a task contain a hold-out."""
        outs = (*self.holdouts, *self.declared.get(task, ()))
        return any(all(_text(factors.get(name)) == level for name, level in out.items()) for out in outs)

    def of(self, task: str, block: int, factors: Mapping[str, Any]) -> str:
        """Return the split of a question, '' if it has a hold-out and its group is not in the test split."""
        split = self.of_block(task, block)
        return "" if split != TEST and self.is_unseen(task, factors) else split


def _words(shares: Mapping[str, int]) -> str:
    return ",".join(f"{name}={share}" for name, share in shares.items())


def _holdout(written: str) -> dict[str, str]:
    parts = [_LEVEL.fullmatch(part) for part in written.split(",")]
    levels = {part[1]: part[2] for part in parts if part is not None}
    if None in parts or len(levels) < len(parts):
        raise WmsError(f"--holdout {written}: expected FACTOR=LEVEL, or a combination such as shape=cone,color=blue")
    return levels


def _text(level: Any) -> str:
    """Return a level as it is written: 2.0 is 2."""
    if isinstance(level, float) and level.is_integer():
        return str(int(level))
    return str(level).lower() if isinstance(level, bool) else str(level)


def factors_of(dataset: DatasetReader, task: str) -> dict[str, tuple[int, dict[str, Any]]]:
    """Return the control group (block) and the levels by factor of each question of a task, by id.

    A factor with named values has the name as its level.
    """
    named = {c.split(".", 1)[1]: c for c in dataset.columns(task) if c.startswith("factor.")}
    named |= {c.split(".", 1)[1]: c for c in dataset.columns(task) if c.startswith("level.") and c[6:] in named}
    rows = dataset.rows(task, ["id", "block", *named.values()])
    return {row["id"]: (row["block"], {name: row[c] for name, c in named.items()}) for row in rows}


#: Four fifths for training, without hold-outs.
DEFAULT_SPLITS = Splits()
