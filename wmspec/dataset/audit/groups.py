"""Effective sample size: the number of independent control groups behind a task's questions."""

from __future__ import annotations

from collections.abc import Sequence

from wmspec.dataset.audit.cases import Unit
from wmspec.dataset.audit.duplicates import Pair
from wmspec.dataset.audit.model import Finding

#: Minimum number of groups for conclusions about the task as a whole.
MIN_GROUPS = 30


def effective_groups(unit: Unit, pairs: Sequence[Pair]) -> int:
    """Return the number of control groups with at least one question that no earlier group has, exactly or visually."""
    block = {case.row["id"]: case.row["block"] for case in unit.cases}
    again = {max(p.first, p.second) for p in pairs if block[p.first] != block[p.second]}
    return len({b for name, b in block.items() if name not in again})


def group_finding(unit: Unit, count: int) -> Finding:
    """Return whether there are enough groups for conclusions about the task rather than about a few scenes."""
    again = unit.draws - count
    what = f"{len(unit.per_instance):,} instances of {count:,} independent groups" + (
        f", {again:,} are duplicates" if again else ""
    )
    if count >= MIN_GROUPS:
        return Finding("groups", unit.name, "holds", what)
    return Finding("groups", unit.name, "unclear", f"{what}; {MIN_GROUPS} are needed for conclusions about the task")
