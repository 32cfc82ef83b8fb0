"""How alike a question's options are: two that nobody can tell apart make it unanswerable."""

from __future__ import annotations

from collections import defaultdict
from itertools import combinations

import numpy as np

from wmspec.audit.cases import Unit
from wmspec.audit.duplicates import ALIKE, MOST_NAMED, different
from wmspec.audit.model import Finding, Likeness

QUANTILES = (0.0, 0.25, 0.5, 0.75, 1.0)


def likeness(unit: Unit) -> Likeness | None:
    """How alike the option pictures are; None if options are words."""
    closest: dict[str, float] = {}
    pairs: dict[str, list[float]] = defaultdict(list)
    for case in unit.looked_at:
        names = case.row["option_name"]
        for i, j in combinations(range(len(case.seen_options)), 2):
            gap = different(case.seen_options[i], case.seen_options[j])
            pairs[" and ".join(sorted((names[i], names[j])))].append(gap)
            closest[case.row["id"]] = min(gap, closest.get(case.row["id"], 1.0))
    if not closest:
        return None
    quantiles = tuple(float(q) for q in np.quantile(list(closest.values()), QUANTILES))
    medians = {name: float(np.median(gaps)) for name, gaps in sorted(pairs.items())}
    return Likeness(unit.name, quantiles, medians, min(closest, key=lambda name: closest[name]))


def judge(unit: Unit, likeness: Likeness | None) -> Finding:
    """Fails where a question has two options that are the same, or look it."""
    same = [c.row["id"] for c in unit.cases if len(set(c.options or c.row["option_text"] or ())) < c.count]
    if same:
        what = f"{len(same):,} questions have the same option twice, such as {', '.join(same[:MOST_NAMED])}"
        return Finding("options", unit.name, "fails", what)
    if likeness is None:
        return Finding("options", unit.name, "holds", "no question has the same words twice")
    least, _, middle, _, _ = likeness.quantiles
    what = f"the closest two differ in {middle:.1%} of the picture (median), {least:.2%} at least ({likeness.closest})"
    return Finding("options", unit.name, "fails" if least < ALIKE else "holds", what)
