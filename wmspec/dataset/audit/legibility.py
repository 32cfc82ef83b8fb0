"""Legibility of the questions, from the column `legibility`."""

from __future__ import annotations

from collections import Counter
from itertools import pairwise
from math import hypot

import numpy as np

from wmspec.dataset.audit import state
from wmspec.dataset.audit.cases import Case, Unit
from wmspec.dataset.audit.model import Finding
from wmspec.runtime.questions.legibility.bounds import BOUNDS, REFERENCE_SIDE, ratio
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


#: The share of questions in which something must move.
MIN_SHARE = 0.95


def motion_finding(unit: Unit) -> Finding | None:
    """Return whether something moves visibly between two pictures; None if it need not, or if this is not known."""
    rows = [case for case in unit.per_instance if _requires_motion(case)]
    if not rows or any(case.row.get("legibility") is not None for case in rows):
        return None
    steps = [_largest_step(case) for case in rows]
    bound = BOUNDS["step"].value
    seen = sum(step >= bound for step in steps)
    what = (
        f"something moves {bound:g} px or more (of {REFERENCE_SIDE}) between two pictures in {seen:,} of {len(rows):,} "
        f"questions ({seen / len(rows):.0%}); median of the largest step {np.median(steps):.1f} px"
    )
    return Finding("motion", unit.name, "holds" if seen >= MIN_SHARE * len(rows) else "fails", what)


def _requires_motion(case: Case) -> bool:
    """Whether the answer requires several moments, and the row shows several with their objects.

    Questions of yes and no are left out: nothing may move where the answer is no.
    """
    required = case.row.get("answer_moments") or 1
    if case.row["answer_standing"] or required < 2 or case.moments < 2:
        return False
    return bool(case.row.get("context_objects")) and set(case.row["option_name"] or ()) != {"yes", "no"}


def _largest_step(case: Case) -> float:
    """Return the largest displacement (px of `REFERENCE_SIDE`) of an object between two pictures of one camera."""
    pictures = list(zip(case.row["context_camera"], state.objects_by_picture(case, "context_objects"), strict=True))
    steps = [0.0]
    for camera in dict.fromkeys(name for name, _ in pictures):
        for before, after in pairwise(seen for name, seen in pictures if name == camera):
            steps += [
                hypot(after[n]["across"] - o["across"], after[n]["down"] - o["down"])
                for n, o in before.items()
                if n in after and o["share"] and after[n]["share"]
            ]
    return REFERENCE_SIDE * max(steps)
