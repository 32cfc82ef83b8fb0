<<<<<<< HEAD
"""The one-factor law: two stages differ only in what depends, by the spec, on the changed factor."""
=======
"""What a counterfactual changes, as sources of dependencies."""
>>>>>>> main

from __future__ import annotations

from wmspec.lang.check.ir.ir import Counterfactual


<<<<<<< HEAD
def violations(depend: Dependencies, before: Document, after: Document, *changed: str) -> tuple[str, ...]:
    """Return the paths of properties that differ between two stages without depending on `changed`.

    `changed` are names of factors, or the result of `changed_by` for a counterfactual.
    """
    return tuple(
        path
        for path, sources in before.differing(after).items()
        if not any(depend.source(source).intersection(changed) for source in sources)
    )


=======
>>>>>>> main
def changed_by(change: Counterfactual) -> tuple[str, ...]:
    """Return the sources that a counterfactual changes: an `owner.property`, presence, or two start times."""
    if change.change == "levels":
        return tuple(change.levels)
    if change.change in ("without", "add"):
        return (f"{change.owner}.there",)
    if change.change == "order":
        return (f"{change.owner}.start", f"{change.property}.start")
    return (f"{change.owner}.{change.property}",)
