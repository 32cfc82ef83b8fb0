"""Effective sample size: from how many independent control groups a task's questions come."""

from __future__ import annotations

from collections.abc import Sequence

from wmspec.dataset.audit.cases import Unit
from wmspec.dataset.audit.duplicates import Pair
from wmspec.dataset.audit.model import Finding

#: With fewer groups than this nothing can be said about more than these.
LEAST_GROUPS = 30


def effective(unit: Unit, pairs: Sequence[Pair]) -> int:
    """The control groups that ask something, to the byte or to the eye, that no group before them does."""
    block = {case.row["id"]: case.row["block"] for case in unit.cases}
    again = {max(p.first, p.second) for p in pairs if block[p.first] != block[p.second]}
    return len({b for name, b in block.items() if name not in again})


def judge(unit: Unit, count: int) -> Finding:
    """Whether there are enough of them to speak of the task rather than of a few of its scenes."""
    again = unit.draws - count
    what = f"{len(unit.once):,} instances of {count:,} independent groups" + (
        f", {again:,} ask the same" if again else ""
    )
    if count >= LEAST_GROUPS:
        return Finding("groups", unit.name, "holds", what)
    return Finding("groups", unit.name, "unclear", f"{what}; {LEAST_GROUPS} are needed to speak of more than these")
