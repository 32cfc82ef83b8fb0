"""Majority votes and agreement of raters."""

from __future__ import annotations

import hashlib
from collections import Counter
from collections.abc import Hashable, Iterable, Mapping, Sequence
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


def alpha(formats: Mapping[Hashable, Iterable[Sequence[Hashable]]]) -> float | None:
    """Return Krippendorff's α of several raters' choices: 1 is full agreement, 0 what guessing yields.

    A format holds the choices of each of its items. Its options are its own categories, since the second option of one
    question is not the second of another; disagreements, observed and expected, are added over formats. With one format
    this is the α of nominal data (Krippendorff, Content Analysis, 2018, ch. 12). Items may have different numbers of
    raters; those with one do not count. None if no items remain, or if all choices of each format are equal.
    """
    disagreements = [_disagreements(list(items)) for items in formats.values()]
    observed, expected = (sum(part) for part in zip(*disagreements, strict=True)) if disagreements else (0.0, 0.0)
    return 1 - observed / expected if expected else None


def _disagreements(items: list[Sequence[Hashable]]) -> tuple[float, float]:
    """Return the observed and expected disagreement of a format, each times its number of choices."""
    rated = [Counter(choices) for choices in items if len(choices) > 1]
    totals = sum(rated, Counter[Hashable]())
    n = totals.total()
    if n < 2:
        return 0.0, 0.0
    observed = sum((c.total() ** 2 - sum(k * k for k in c.values())) / (c.total() - 1) for c in rated)
    return observed, (n * n - sum(k * k for k in totals.values())) / (n - 1)
