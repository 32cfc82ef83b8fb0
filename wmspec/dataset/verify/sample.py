"""Random samples that find a given share of changes with a given probability."""

from __future__ import annotations

import math
import random
from collections.abc import Sequence
from typing import TypeVar

T = TypeVar("T")

#: A default sample finds changes in this share of the questions with this probability.
SHARE, FOUND = 0.05, 0.99


def found(population: int, drawn: int, share: float = SHARE) -> float:
    """Return the probability that a sample without replacement contains one of the changed items.

    `share` of the population, rounded up, is changed.
    """
    changed = math.ceil(share * population)
    missed = 1.0
    for number in range(drawn):
        missed *= max(0, population - changed - number) / (population - number)
    return 1.0 - missed if population else 1.0


def sample_size(population: int, share: float = SHARE, probability: float = FOUND) -> int:
    """Return the smallest sample that finds a change in `share` of the population with at least the probability."""
    changed, missed, drawn = math.ceil(share * population), 1.0, 0
    while drawn < population and missed > 1.0 - probability:
        missed *= max(0, population - changed - drawn) / (population - drawn)
        drawn += 1
    return drawn


def draw(items: Sequence[T], count: int, seed: int, key: str) -> list[T]:
    """Return a random sample of `count` items, or all of them."""
    return random.Random(f"{seed} {key}").sample(items, min(count, len(items)))  # noqa: S311  its seed comes from `secrets`
