"""Similarity of option pictures: indistinguishable options, and options that similarity alone identifies."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from wmspec.dataset.audit.cases import Case, Unit
from wmspec.dataset.audit.duplicates import ALIKE_SHARE, MAX_EXAMPLES, pixel_difference
from wmspec.dataset.audit.model import Finding, Likeness

QUANTILES = (0.0, 0.25, 0.5, 0.75, 1.0)


def option_similarity(unit: Unit) -> Likeness | None:
    """Return the similarity of the option pictures; None if options are words."""
    closest: dict[str, float] = {}
    pairs: dict[str, list[float]] = defaultdict(list)
    for case in unit.sampled:
        names = case.row["option_name"]
        for i, j in combinations(range(len(case.option_thumbnails)), 2):
            gap = pixel_difference(case.option_thumbnails[i], case.option_thumbnails[j])
            pairs[" and ".join(sorted((names[i], names[j])))].append(gap)
            closest[case.row["id"]] = min(gap, closest.get(case.row["id"], 1.0))
    if not closest:
        return None
    quantiles = tuple(float(q) for q in np.quantile(list(closest.values()), QUANTILES))
    medians = {name: float(np.median(gaps)) for name, gaps in sorted(pairs.items())}
    return Likeness(unit.name, quantiles, medians, min(closest, key=lambda name: closest[name]))


def similarity_finding(unit: Unit, likeness: Likeness | None) -> Finding:
    """Return the finding; it fails where two options of a question are equal or look equal."""
    same = [c.row["id"] for c in unit.cases if len(set(c.options or c.row["option_text"] or ())) < c.count]
    if same:
        what = f"{len(same):,} questions have the same option twice, such as {', '.join(same[:MAX_EXAMPLES])}"
        return Finding("options", unit.name, "fails", what)
    if likeness is None:
        return Finding("options", unit.name, "holds", "no question has the same words twice")
    least, _, middle, _, _ = likeness.quantiles
    what = f"the closest two differ in {middle:.1%} of the picture (median), {least:.2%} at least ({likeness.closest})"
    return Finding("options", unit.name, "fails" if least < ALIKE_SHARE else "holds", what)


def rules(cases: Sequence[Case]) -> dict[str, NDArray[np.float64]]:
    """Return rules of thumb for choosing a picture, each with a score for every option; the highest is chosen.

    Similarity to the last picture shown, prominence (the number of pixels that differ from the other options), and the
    size of the file.
    """
    apart = np.concatenate([from_others(case) for case in cases])
    scored = {"the option that differs most from the others": apart, "the option that differs least": -apart}
    sizes = np.concatenate([np.array(case.option_sizes, dtype=np.float64) for case in cases])
    scored |= {"the option with the largest file": sizes, "the option with the smallest file": -sizes}
    if cases[0].context_thumbnails:
        gaps = [pixel_difference(o, c.context_thumbnails[-1]) for c in cases for o in c.option_thumbnails]
        scored["the option most like the last picture"] = -np.array(gaps)
        scored["the option least like the last picture"] = np.array(gaps)
    return scored


def from_others(case: Case) -> NDArray[np.float64]:
    """Return the mean difference of each option from the others."""
    options = case.option_thumbnails
    return np.array([sum(pixel_difference(a, b) for b in options) / max(1, len(options) - 1) for a in options])
