"""Stability of answers: do the engines agree, and does a nudge leave the answer as it is?"""

from __future__ import annotations

from wmspec.dataset.audit.cases import Unit
from wmspec.dataset.audit.model import Finding
from wmspec.dataset.audit.statistics import clopper_pearson
from wmspec.dataset.build.reader import DatasetReader

#: A task fails if surely fewer of its answers hold than this.
LEAST_STABLE = 0.95
#: Reasons for which an answer does not hold.
TURNED = ("unstable", "disagreement")


def stability(dataset: DatasetReader, task: str, parts: list[Unit]) -> tuple[Finding, float | None]:
    """The share of questions whose answers hold, of those that nothing else is wrong with; None if it is unknown.

    What the engines disagree on, and what a nudge turns, is among the rejected, or, where no consensus was asked for,
    to be seen in the votes.
    """
    turned = {
        (r["index"], r["question"])
        for r in dataset.manifest["rejected"]["list"]
        if r["task"] == task and r["reason"] in TURNED
    }
    asked = set(turned)
    for case in (case for part in parts for case in part.cases):
        question = (case.row["index"], case.row["question"])
        asked.add(question)
        if any(v["rejected"] is None and v["answer"] != case.row["answer"] for v in case.row["agreement"]):
            turned.add(question)
    if not asked:
        return Finding("stability", task, "unclear", "there are no questions"), None
    held = len(asked) - len(turned)
    low, high = clopper_pearson(held, len(asked), 0.95)
    engines = len(dataset.engines)
    whom = f"in {engines} engines" if engines > 1 else "in the one engine, which nothing was compared with"
    what = f"{held:,} of {len(asked):,} answers hold {whom} ({held / len(asked):.1%}; {low:.1%} to {high:.1%})"
    if high < LEAST_STABLE:
        return Finding("stability", task, "fails", what), held / len(asked)
    if engines == 1:
        return Finding("stability", task, "told", what), None
    return Finding("stability", task, "holds", what), held / len(asked)
