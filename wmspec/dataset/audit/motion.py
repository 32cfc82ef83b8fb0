"""Motion between the pictures shown, for datasets without the column `legibility`: is there any that can be seen?

The positions come from `context_objects`. An answer about a change is in the difference of two pictures. Where no
object moves enough to be seen, nothing in the pictures decides it.
"""

from __future__ import annotations

from itertools import pairwise
from math import hypot

import numpy as np

from wmspec.dataset.audit import state
from wmspec.dataset.audit.cases import Case, Unit
from wmspec.dataset.audit.model import Finding
from wmspec.runtime.questions.legibility.bounds import BOUNDS, REFERENCE_SIDE

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
