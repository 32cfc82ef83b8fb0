"""Majority votes and agreement of raters."""

from __future__ import annotations

import hashlib
from collections import Counter
from collections.abc import Hashable, Iterable, Sequence
from typing import TypeVar

Vote = TypeVar("Vote", bound=Hashable)


def majority(id: str, votes: Iterable[Vote]) -> Vote:
    """Return the most frequent vote; ties are broken at random, seeded by the question's id. Raises ValueError without
    votes.
    """
    counts = Counter(votes)
    most = max(counts.values())
    best = sorted((vote for vote, count in counts.items() if count == most), key=str)
    return best[int.from_bytes(hashlib.sha256(id.encode()).digest()[:4], "big") % len(best)]


def fleiss_kappa(items: Iterable[Sequence[Hashable]]) -> float | None:
    """Return Fleiss' κ (1971) of several raters' choices for each item: 1 is full agreement, 0 chance level.

    Items may have different numbers of raters. Each item has the same weight in the observed agreement, each choice in
    the expected one. With equal numbers this is Fleiss' formula. Items with fewer than two choices are ignored. None if
    no items remain, or if all choices are equal.
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
