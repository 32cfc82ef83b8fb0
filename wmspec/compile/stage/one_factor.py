"""What a counterfactual changes, as sources of dependencies."""

from __future__ import annotations

from wmspec.lang.check.ir.ir import Counterfactual


def changed_by(change: Counterfactual) -> tuple[str, ...]:
    """What a counterfactual changes, as sources: an `owner.property`, whether an action happens, or when two do."""
    if change.change == "levels":
        return tuple(change.levels)
    if change.change in ("without", "add"):
        return (f"{change.owner}.there",)
    if change.change == "order":
        return (f"{change.owner}.start", f"{change.property}.start")
    return (f"{change.owner}.{change.property}",)
