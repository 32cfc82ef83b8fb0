"""Splits of a dataset for training: by control groups, with levels and pairs of levels that training never sees."""

from __future__ import annotations

import hashlib
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from wmspec.core.diagnostics import WmsError, suggestion
from wmspec.dataset.build.reader import DatasetReader

#: The names of splits, in order, and their default shares in percent.
DEFAULT_SHARES = {"train": 80, "validation": 10, "test": 10}
_LEVEL = re.compile(r"\s*([a-z][a-z0-9_]*)\s*=\s*([^,=]+?)\s*")


@dataclass(frozen=True)
class Splits:
    """Shares of splits in percent, and hold-outs: levels by factor that never occur together in training.

    A control group is in one split, which depends on its name alone: another dataset of the same design and seed has
    the same splits. Questions with a hold-out in a group for training or validation are in no split.
    """

    shares: Mapping[str, int] = field(default_factory=lambda: dict(DEFAULT_SHARES))
    holdouts: tuple[Mapping[str, str], ...] = ()

    @classmethod
    def parse(cls, shares: str, holdouts: Sequence[str]) -> Splits:
        """Return splits from `train=80,validation=10,test=10` and hold-outs such as `shape=cone,color=blue`.

        Raises WmsError for anything else.
        """
        parsed = dict(DEFAULT_SHARES)
        if shares:
            parts = [part.partition("=") for part in shares.split(",")]
            if any(name.strip() not in DEFAULT_SHARES or not share.strip().isdecimal() for name, _, share in parts):
                raise WmsError(f"--shares {shares}: expected shares in percent, such as train=80,validation=10,test=10")
            parsed = {name.strip(): int(share) for name, _, share in parts}
        if sum(parsed.values()) != 100:
            raise WmsError(f"--shares {shares}: the shares add up to {sum(parsed.values())}, not to 100")
        return cls(parsed, tuple(map(_holdout, holdouts)))

    def check(self, dataset: DatasetReader) -> None:
        """Raise WmsError if no task of a dataset has the factors of a hold-out."""
        known = {c.split(".", 1)[1] for task in dataset.tasks for c in dataset.columns(task) if c.startswith("factor.")}
        for holdout in self.holdouts:
            for name in holdout:
                if name not in known:
                    hint = suggestion(name, sorted(known))
                    raise WmsError(f"--holdout {name}: no task has this factor; {hint}".rstrip("; "))

    def of_group(self, group: str) -> str:
        """Return the split of a control group."""
        digest = hashlib.sha256(f"split\n{group}".encode()).digest()
        place, reached = int.from_bytes(digest[:8], "big") / 2**64 * 100, 0
        for name, share in self.shares.items():
            reached += share
            if place < reached:
                return name
        return [*self.shares][-1]

    def is_unseen(self, factors: Mapping[str, Any]) -> bool:
        """Whether levels by factor contain a hold-out."""
        return any(all(_text(factors.get(name)) == level for name, level in out.items()) for out in self.holdouts)

    def of(self, group: str, factors: Mapping[str, Any]) -> str:
        """Return the split of a question, '' if it has a hold-out and its group is not in the test split."""
        split = self.of_group(group)
        return "" if split != "test" and self.is_unseen(factors) else split


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


def factors_of(dataset: DatasetReader, task: str) -> dict[str, tuple[str, dict[str, Any]]]:
    """Return the control group and the levels by factor of each question of a task, by id.

    A factor with named values has the name as its level.
    """
    named = {c.split(".", 1)[1]: c for c in dataset.columns(task) if c.startswith("factor.")}
    named |= {c.split(".", 1)[1]: c for c in dataset.columns(task) if c.startswith("level.") and c[6:] in named}
    rows = dataset.rows(task, ["id", "block", *named.values()])
    return {row["id"]: (f"{task}/{row['block']}", {name: row[c] for name, c in named.items()}) for row in rows}


#: Four fifths for training, without hold-outs.
DEFAULT_SPLITS = Splits()
