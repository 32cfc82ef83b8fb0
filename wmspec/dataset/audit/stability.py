"""Stability of answers: agreement of engines, and robustness to nudges."""

from __future__ import annotations

from wmspec.dataset.audit.cases import Unit
from wmspec.dataset.audit.model import Finding
from wmspec.dataset.audit.statistics import clopper_pearson
from wmspec.dataset.build.reader import DatasetReader

#: A task fails if its share of stable answers is significantly below this.
MIN_STABLE = 0.95
#: Rejection reasons of unstable answers.
UNSTABLE_REASONS = ("unstable", "disagreement")


def stability(dataset: DatasetReader, task: str, parts: list[Unit]) -> tuple[Finding, float | None]:
    """Return the share of stable answers among otherwise valid questions; None if unknown.

    Unstable answers and disagreements are among the rejections, or in the votes if no consensus was required.
    """
    unstable_keys = {
        (r["index"], r["question"])
        for r in dataset.manifest["rejected"]["list"]
        if r["task"] == task and r["reason"] in UNSTABLE_REASONS
    }
    counted = set(unstable_keys)
    for case in (case for part in parts for case in part.cases):
        question = (case.row["index"], case.row["question"])
        counted.add(question)
        if any(v["rejected"] is None and v["answer"] != case.row["answer"] for v in case.row["agreement"]):
            unstable_keys.add(question)
    if not counted:
        return Finding("stability", task, "unclear", "there are no questions"), None
    held = len(counted) - len(unstable_keys)
    low, high = clopper_pearson(held, len(counted), 0.95)
    engines = len(dataset.engines)
    whom = f"in {engines} engines" if engines > 1 else "in a single engine, without comparison"
    what = f"{held:,} of {len(counted):,} answers hold {whom} ({held / len(counted):.1%}; {low:.1%} to {high:.1%})"
    if high < MIN_STABLE:
        return Finding("stability", task, "fails", what), held / len(counted)
    if engines == 1:
        return Finding("stability", task, "reported", what), None
    return Finding("stability", task, "holds", what), held / len(counted)
