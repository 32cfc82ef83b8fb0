"""Intervals by cluster bootstrap: what belongs together is drawn together, so that no question counts as news twice."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

#: How often clusters are drawn, how many draws are in memory at a time, and how sure an interval is.
DRAWS, BATCH, CONFIDENCE = 2000, 250, 0.95
#: Of fewer clusters no interval is told.
LEAST_CLUSTERS = 5

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Estimate:
    """A number with its 95 % interval and how many questions it rests on.

    The interval is None where there are too few clusters to say.
    """

    value: float
    low: float | None
    high: float | None
    questions: int

    @property
    def sure(self) -> bool:
        """Whether it has an interval."""
        return self.low is not None


def rng(*key: object) -> np.random.Generator:
    """A generator that hangs on its key alone, so that draws do not move when something else is added."""
    digest = hashlib.sha256("/".join(map(str, key)).encode()).digest()
    return np.random.default_rng(int.from_bytes(digest[:8], "big"))


def sums(values: Floats, cluster: ArrayLike) -> tuple[Floats, Floats]:
    """Of values (n, m), NaN where there is none: their sums and their numbers in every cluster, (g, m) each."""
    _, which = np.unique(np.asarray(cluster, dtype=str), return_inverse=True)
    total = np.zeros((which.max(initial=-1) + 1, values.shape[1]))
    count = np.zeros_like(total)
    np.add.at(total, which, np.nan_to_num(values))
    np.add.at(count, which, ~np.isnan(values))
    return total, count


def resampled(parts: tuple[Floats, ...], key: object, draws: int = DRAWS) -> tuple[Floats, ...]:
    """Sums over clusters drawn with replacement: each part (g, ...) becomes (draws, ...), all by the same draws."""
    clusters = len(parts[0])
    generator = rng("bootstrap", key, clusters)
    even = np.full(clusters, 1 / max(1, clusters))
    made: list[list[Floats]] = [[] for _ in parts]
    for begin in range(0, draws, BATCH):
        weights = generator.multinomial(clusters, even, size=min(BATCH, draws - begin)).astype(np.float64)
        for kept, part in zip(made, parts, strict=True):
            kept.append((weights @ part.reshape(clusters, -1)).reshape(len(weights), *part.shape[1:]))
    return tuple(np.concatenate(kept) for kept in made)


def ratio(above: Floats, below: Floats) -> Floats:
    """`above / below`, NaN where there is nothing below."""
    return np.asarray(np.divide(above, below, out=np.full(np.shape(above), np.nan), where=np.asarray(below) > 0))


def estimate(value: float, draws: Floats, questions: int, clusters: int) -> Estimate:
    """A number with the percentile interval of its draws."""
    draws = draws[~np.isnan(draws)]
    if clusters < LEAST_CLUSTERS or not len(draws):
        return Estimate(float(value), None, None, questions)
    low, high = np.quantile(draws, [(1 - CONFIDENCE) / 2, (1 + CONFIDENCE) / 2])
    return Estimate(float(value), float(low), float(high), questions)


def means(values: Floats, cluster: ArrayLike, key: object) -> tuple[tuple[Estimate, ...], Floats]:
    """The mean of every column of values (n, m) with its interval, and the draws (DRAWS, m) of the means."""
    total, count = sums(values, cluster)
    drawn = ratio(*resampled((total, count), key))
    value = ratio(total.sum(0), count.sum(0))
    estimates = tuple(
        estimate(value[j], drawn[:, j], int(count[:, j].sum()), int((count[:, j] > 0).sum()))
        for j in range(values.shape[1])
    )
    return estimates, drawn
