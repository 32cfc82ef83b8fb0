"""The sources of dependencies that a counterfactual changes."""

from __future__ import annotations

from wmspec.lang.check.ir.ir import Counterfactual


def changed_by(change: Counterfactual) -> tuple[str, ...]:
    """Return the sources that a counterfactual changes: an `owner.property`, presence, or two start times."""
    if change.change == "levels":
        return tuple(change.levels)
    if change.change == "without":
        return (f"{change.owner}.there", f"{change.owner}.present")
    if change.change == "add":
        return (f"{change.owner}.there",)
    if change.change == "order":
        return (f"{change.owner}.start", f"{change.property}.start")
    if change.property == "mass":  # which takes the place of a density
        return (f"{change.owner}.mass", f"{change.owner}.density")
    return (f"{change.owner}.{change.property}",)
