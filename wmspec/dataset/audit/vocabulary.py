"""Vocabulary: options of one question that do not exclude one another, such as `planks` beside `wood`."""

from __future__ import annotations

from collections import Counter
from itertools import permutations

from wmspec.dataset.audit.cases import Case, Unit
from wmspec.dataset.audit.duplicates import MAX_EXAMPLES
from wmspec.dataset.audit.model import Finding
from wmspec.lang.check.tables.overlaps import is_kind_of


def vocabulary_finding(unit: Unit) -> Finding | None:
    """Return whether the options in words exclude one another; None if they are pictures or there are none."""
    cases = [case for case in unit.per_instance if case.row["option_text"]]
    if not cases:
        return None
    overlaps = Counter(pair for case in cases for pair in _overlaps(case))
    affected = sum(bool(_overlaps(case)) for case in cases)
    if not affected:
        return Finding("vocabulary", unit.name, "holds", "the options of each question exclude one another")
    pairs = ", ".join(f"`{kind}` is a kind of `{whole}`" for (kind, whole), _ in overlaps.most_common(MAX_EXAMPLES))
    what = f"{affected:,} of {len(cases):,} questions ({affected / len(cases):.0%}) offer words that overlap: {pairs}"
    return Finding("vocabulary", unit.name, "fails", what)


def _overlaps(case: Case) -> list[tuple[str, str]]:
    """Return the pairs of options of which the first is a kind of the second."""
    return [(kind, whole) for kind, whole in permutations(case.row["option_text"], 2) if is_kind_of(kind, whole)]
