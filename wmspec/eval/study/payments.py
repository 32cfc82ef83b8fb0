"""The payment sheet: a line for each person, for the site that invited them."""

from __future__ import annotations

import csv
import io
from collections.abc import Sequence

from wmspec.eval.study.collect import Rater

#: The columns, in order.
COLUMNS = (
    "rater", "study_id", "session_id", "code", "answered", "steps", "checks_passed", "checks", "minutes", "verdict",
)  # fmt: skip


def verdict(rater: Rater) -> str:
    """Return `pay` for a person who answered everything and whose checks suffice, else `incomplete` or `look`."""
    if rater.answered < rater.steps:
        return "incomplete"
    return "pay" if rater.counted else "look"


def payments(raters: Sequence[Rater]) -> str:
    """Return the sheet as CSV, in the order of raters."""
    text = io.StringIO()
    out = csv.DictWriter(text, COLUMNS, lineterminator="\n")
    out.writeheader()
    for rater in raters:
        known = {name: getattr(rater, name) for name in COLUMNS if name not in ("minutes", "verdict")}
        out.writerow({**known, "minutes": f"{rater.minutes:.1f}", "verdict": verdict(rater)})
    return text.getvalue()
