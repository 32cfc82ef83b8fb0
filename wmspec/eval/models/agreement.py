"""What raters choose together, and how far they agree."""

from __future__ import annotations

import hashlib
from collections import Counter
from collections.abc import Hashable, Iterable, Sequence
from typing import TypeVar

Vote = TypeVar("Vote", bound=Hashable)


def majority(id: str, votes: Iterable[Vote]) -> Vote:
    """What most chose; a draw whose seed is the question's id decides among equals. Raises ValueError without votes."""
    counts = Counter(votes)
    most = max(counts.values())
    best = sorted((vote for vote, count in counts.items() if count == most), key=str)
    return best[int.from_bytes(hashlib.sha256(id.encode()).digest()[:4], "big") % len(best)]


def fleiss_kappa(items: Iterable[Sequence[Hashable]]) -> float | None:
    """Fleiss' κ (1971) of several raters' choices for each item: 1 is full agreement, 0 what chance would give.

    Items may have different numbers of raters, as where somebody stopped: each weighs the same in the agreement
    observed, and each choice in the one expected. With equal numbers this is Fleiss' formula. Items with fewer than two
    choices say nothing. None if there are none others, or if all choices are the same.
    """
    rated = [Counter(choices) for choices in items if len(choices) > 1]
    if not rated:
        return None
    totals: Counter[Hashable] = Counter()
    observed = 0.0
    for counts in rated:
        totals += counts
        n = counts.total()
        observed += sum(c * (c - 1) for c in counts.values()) / (n * (n - 1)) / len(rated)
    expected = sum((c / totals.total()) ** 2 for c in totals.values())
    return None if len(totals) == 1 else (observed - expected) / (1 - expected)
