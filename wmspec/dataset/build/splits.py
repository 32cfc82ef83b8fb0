"""Splits for training: shares of control groups, and the instances of a split."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

from wmspec.compile.design.design import Design
from wmspec.core.diagnostics import WmsError, suggestion
from wmspec.lang.check.ir.ir import TaskSpec

#: The names of splits, in order, and their default shares in percent.
DEFAULT_SHARES = {"train": 80, "validation": 10, "test": 10}
#: The split that has the held-out levels.
TEST = "test"


@dataclass(frozen=True)
class Split:
    """A split of a design, and the shares of all splits in percent."""

    name: str
    shares: Mapping[str, int] = field(default_factory=lambda: dict(DEFAULT_SHARES))

    @classmethod
    def of(cls, record: Any) -> Split | None:
        """Return the split that `record` gives, or None for None. Raises KeyError or TypeError for anything else."""
        return None if record is None else cls(record["name"], dict(record["shares"]))

    @property
    def record(self) -> dict[str, Any]:
        """The split as JSON values."""
        return {"name": self.name, "shares": dict(self.shares)}

    def contains(self, design: Design) -> Callable[[int], bool]:
        """Return whether an instance, by index, is in the split: by its control group, and by its hold-outs."""

        def inside(index: int) -> bool:
            if split_of_group(f"{design.spec.name}/{split_unit(design, design.block_of(index))}", self.shares) != (
                self.name
            ):
                return False
            return self.name == TEST or not design.spec.is_held_out(design[index].factors)

        return inside

    def nothing_left(self, design: Design) -> WmsError:
        """Return the error for a task without an instance in the split."""
        name, count = design.spec.name, design.blocks.count
        groups = "one control group" if count == 1 else f"{count:,} control groups"
        what = f"`{name}`: the split `{self.name}` has none of its instances ({groups})"
        remedy = "control groups are whole: use `design groups of N` with more groups, or other --shares"
        return WmsError(what, design.spec.plan.place, remedy)


def parse_split(name: str, shares: str) -> Split | None:
    """Return a split from its name and shares such as `train=80,validation=10,test=10`; None without a name.

    Raises WmsError for shares without a split, an unknown name, or a share of 0.
    """
    if not name:
        if shares:
            raise WmsError("--shares belong to --split, such as --split train")
        return None
    if name not in DEFAULT_SHARES:
        raise WmsError(f"--split {name}: there is no such split; {suggestion(name, DEFAULT_SHARES)}".rstrip("; "))
    split = Split(name, parse_shares(shares))
    if not split.shares.get(name):
        raise WmsError(f"--split {name}: its share is 0 percent")
    return split


def parse_shares(shares: str) -> dict[str, int]:
    """Return the shares of splits from `train=80,validation=10,test=10`; the default for ''.

    Raises WmsError for anything else.
    """
    if not shares:
        return dict(DEFAULT_SHARES)
    parts = [part.partition("=") for part in shares.split(",")]
    if any(name.strip() not in DEFAULT_SHARES or not share.strip().isdecimal() for name, _, share in parts):
        raise WmsError(f"--shares {shares}: expected shares in percent, such as train=80,validation=10,test=10")
    parsed = {name.strip(): int(share) for name, _, share in parts}
    if len(parsed) < len(parts):
        raise WmsError(f"--shares {shares}: a split is named twice")
    if sum(parsed.values()) != 100:
        raise WmsError(f"--shares {shares}: the shares add up to {sum(parsed.values())}, not to 100")
    return {name: parsed[name] for name in DEFAULT_SHARES if name in parsed}


def split_of_group(group: str, shares: Mapping[str, int]) -> str:
    """Return the split of a control group, which depends on its name and the shares alone."""
    digest = hashlib.sha256(f"split\n{group}".encode()).digest()
    place, reached = int.from_bytes(digest[:8], "big") / 2**64 * 100, 0
    for name, share in shares.items():
        reached += share
        if place < reached:
            return name
    return [*shares][-1]


def split_unit(design: Design, block: int) -> int:
    """Return the block that stands for a control group in splits: groups that are balanced together stay together."""
    return min(design.balance_batch(block))


def declared_holdouts(spec: TaskSpec) -> list[dict[str, Any]]:
    """Return the hold-outs of a spec as JSON values: levels by factor, named levels by their names."""
    factors = {factor.name: factor for factor in spec.factors}
    return [
        {name: factors[name].called(level) or level for name, level in zip(out.factors, levels, strict=True)}
        for out in spec.holdouts
        for levels in out.levels
    ]
