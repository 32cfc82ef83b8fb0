"""Marks on true options: small differences that follow the truth."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from wmspec.dataset.verify.model import Difference

#: Probability below which chance does not explain that the differences follow the truth.
CHANCE = 1e-4


@dataclass(frozen=True)
class OptionScores:
    """How much each option's picture differs from the one made again, and which option is true."""

    scores: Sequence[float]
    answer: int


def marked_truths(questions: Sequence[OptionScores]) -> Iterator[Difference]:
    """Yield a difference if the true option differs the most, or the least, more often than chance explains."""
    for words, sign in (("more", 1.0), ("less", -1.0)):
        hits, chances = 0, []
        for question in questions:
            scores = [sign * score for score in question.scores]
            best = max(scores)
            if scores.count(best) == 1 and min(scores) < best:
                chances.append(1 / len(scores))
                hits += scores[question.answer] == best
        if chances and tail(chances, hits) < CHANCE:
            text = f"the true option differs {words} than the others in {hits} of {len(chances)} questions"
            yield Difference("pictures", "option_image", text)


def tail(chances: Sequence[float], hits: int) -> float:
    """Return the probability of at least `hits` hits in independent trials with the given chances."""
    counts = np.ones(1)
    for chance in chances:
        counts = np.convolve(counts, [1 - chance, chance])
    return float(counts[hits:].sum())
