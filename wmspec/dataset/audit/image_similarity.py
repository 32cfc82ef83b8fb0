"""How alike pictures are: options that nobody can tell apart, and options that are picked by their likeness alone."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from wmspec.dataset.audit.cases import Case, Unit
from wmspec.dataset.audit.duplicates import ALIKE, MOST_NAMED, different
from wmspec.dataset.audit.model import Finding, Likeness

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


def rules(cases: Sequence[Case]) -> dict[str, NDArray[np.float64]]:
    """Rules of thumb by which to pick a picture, each with a score for every option: the highest is picked.

    How like the last picture shown it is (similarity), and by how many pixels it differs from the others (prominence).
    """
    apart = np.concatenate([_from_others(case) for case in cases])
    scored = {"the option that differs most from the others": apart, "the option that differs least": -apart}
    if cases[0].seen_context:
        gaps = [different(o, c.seen_context[-1]) for c in cases for o in c.seen_options]
        scored["the option most like the last picture"] = -np.array(gaps)
        scored["the option least like the last picture"] = np.array(gaps)
    return scored


def _from_others(case: Case) -> NDArray[np.float64]:
    options = case.seen_options
    return np.array([sum(different(a, b) for b in options) / max(1, len(options) - 1) for a in options])
