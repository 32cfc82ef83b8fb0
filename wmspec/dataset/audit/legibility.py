"""Legibility of the questions, from the column `legibility`."""

from __future__ import annotations

from collections import Counter

from wmspec.dataset.audit.cases import Unit
from wmspec.dataset.audit.model import Finding
from wmspec.runtime.questions.legibility.bounds import BOUNDS, ratio
from wmspec.runtime.questions.model import Legibility


def legibility_finding(unit: Unit) -> Finding:
    """Return the share of legible questions: one per instance, of which every measure must be within its bound.

    It is not measured in datasets without the column, and in those of own pictures.
    """
    measured = [case.row.get("legibility") for case in unit.per_instance]
    rows = [[Legibility(**each) for each in row if each["name"] in BOUNDS] for row in measured if row is not None]
    if not rows:
        return Finding("legibility", unit.name, "reported", "legibility was not measured")
    faults = Counter(each.name for row in rows for each in row if ratio(each) < 1)
    legible = sum(all(ratio(each) >= 1 for each in row) for row in rows)
    what = f"{legible:,} of {len(rows):,} questions are legible ({_percent(legible, len(rows))})"
    if not faults:
        return Finding("legibility", unit.name, "holds", what)
    worst = ", ".join(_fault(rows, name, count) for name, count in faults.most_common())
    return Finding("legibility", unit.name, "fails", f"{what}; not within the bound: {worst}")


def _fault(rows: list[list[Legibility]], name: str, count: int) -> str:
    """Return how many questions a measure fails, with the worst value and the bound."""
    worst = min((each for row in rows for each in row if each.name == name), key=ratio)
    limit = "most" if BOUNDS[name].at_most else "least"
    return f"`{name}` in {count:,} (worst {worst.value:.3g}, at {limit} {f'{worst.bound:g} {worst.unit}'.strip()})"


def _percent(part: int, whole: int) -> str:
    """Return a share that is 100 % only if it is all."""
    return f"{100 * part // whole} %"
