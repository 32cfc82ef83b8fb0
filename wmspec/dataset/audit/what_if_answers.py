"""Whether what-if questions need a what-if: how often the answer is that of the episode as it is."""

from __future__ import annotations

from wmspec.dataset.audit.cases import Unit
from wmspec.dataset.audit.model import Finding

#: Share of questions with the actual answer above which, or of two options below one minus it, nothing is imagined.
MAX_SHARE = 0.9


def what_if_finding(unit: Unit) -> Finding | None:
    """Return the finding about what-ifs with words as answers; None for other questions."""
    cases = [case for case in unit.per_instance if case.row.get("actual_value") is not None and not case.open]
    if not cases:
        return None
    same = sum(case.row["answer_value"] == case.row["actual_value"] for case in cases) / len(cases)
    binary = all(case.count == 2 for case in cases)
    what = f"the answer is that of the episode as it is in {same:.0%} of {len(cases):,} what-if questions"
    if same > MAX_SHARE or (binary and same < 1 - MAX_SHARE):
        what += ", so they can be answered without imagining the change"
        return Finding("what-if", unit.name, "unclear", what)
    return Finding("what-if", unit.name, "holds", what)
