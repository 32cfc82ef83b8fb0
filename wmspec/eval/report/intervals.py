"""Intervals by cluster bootstrap: dependent questions are drawn together."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

#: Number of bootstrap draws, number of draws in memory at a time, and confidence level.
DRAWS, BATCH, CONFIDENCE = 2000, 250, 0.95
#: Minimum number of clusters for an interval.
MIN_CLUSTERS = 5

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Estimate:
    """A number with its 95 % interval and the number of questions behind it.

    The interval is None if there are too few clusters.
    """

    value: float
    low: float | None
    high: float | None
    questions: int

    @property
    def sure(self) -> bool:
        """Whether it has an interval."""
        return self.low is not None


def seeded_generator(*key: object) -> np.random.Generator:
    """Return a generator seeded by the key alone, so that draws do not depend on other analyses."""
    digest = hashlib.sha256("/".join(map(str, key)).encode()).digest()
    return np.random.default_rng(int.from_bytes(digest[:8], "big"))


def cluster_sums(values: Floats, cluster: ArrayLike) -> tuple[Floats, Floats]:
    """Return sums and counts of values (n, m) in every cluster, (g, m) each; NaN values are skipped."""
    _, which = np.unique(np.asarray(cluster, dtype=str), return_inverse=True)
    total = np.zeros((which.max(initial=-1) + 1, values.shape[1]))
    count = np.zeros_like(total)
    np.add.at(total, which, np.nan_to_num(values))
    np.add.at(count, which, ~np.isnan(values))
    return total, count


def resample_sums(parts: tuple[Floats, ...], key: object, draws: int = DRAWS) -> tuple[Floats, ...]:
    """Return sums over resampled clusters: each part (g, ...) becomes (draws, ...), all with the same draws."""
    clusters = len(parts[0])
    generator = seeded_generator("bootstrap", key, clusters)
    even = np.full(clusters, 1 / max(1, clusters))
    made: list[list[Floats]] = [[] for _ in parts]
    for begin in range(0, draws, BATCH):
        weights = generator.multinomial(clusters, even, size=min(BATCH, draws - begin)).astype(np.float64)
        for kept, part in zip(made, parts, strict=True):
            kept.append((weights @ part.reshape(clusters, -1)).reshape(len(weights), *part.shape[1:]))
    return tuple(np.concatenate(kept) for kept in made)


def ratio(above: Floats, below: Floats) -> Floats:
    """Return `above / below`, NaN where `below` is 0."""
    return np.asarray(np.divide(above, below, out=np.full(np.shape(above), np.nan), where=np.asarray(below) > 0))


def estimate(value: float, draws: Floats, questions: int, clusters: int) -> Estimate:
    """Return a number with the percentile interval of its draws, which contains the number."""
    draws = draws[~np.isnan(draws)]
    if clusters < MIN_CLUSTERS or not len(draws):
        return Estimate(float(value), None, None, questions)
    low, high = np.quantile(draws, [(1 - CONFIDENCE) / 2, (1 + CONFIDENCE) / 2])
    return Estimate(float(value), min(float(low), float(value)), max(float(high), float(value)), questions)


def spread_at_bounds(value: Floats, drawn: Floats, clusters: NDArray[np.intp], key: object) -> Floats:
    """Return draws (d, m) of shares (m,) with those of shares at 0 or 1 replaced, as resampling never leaves a bound.

    These are drawn from the posterior of a share with Jeffreys' prior, Beta(g + 1/2, 1/2), where all g `clusters` (m,)
    are right: all questions of a cluster count as one, the most careful assumption on their dependence.
    """
    spread = drawn.copy()
    for j in np.flatnonzero((value <= 0) | (value >= 1)):
        off = seeded_generator("bound", key, int(clusters[j])).beta(0.5, clusters[j] + 0.5, len(drawn))
        spread[:, j] = off if value[j] <= 0 else 1 - off
    return spread


def mean_estimates(values: Floats, cluster: ArrayLike, key: object) -> tuple[tuple[Estimate, ...], Floats]:
    """Return the mean of every column of values (n, m) with its interval, and the draws (DRAWS, m) of the means."""
    return share_estimates(*cluster_sums(values, cluster), key)


def share_estimates(right: Floats, count: Floats, key: object) -> tuple[tuple[Estimate, ...], Floats]:
    """Return the shares (m,) of sums over clusters, (g, m) each, with their intervals, and their draws (DRAWS, m)."""
    value, clusters = ratio(right.sum(0), count.sum(0)), (count > 0).sum(0)
    drawn = spread_at_bounds(value, ratio(*resample_sums((right, count), key)), clusters, key)
    estimates = tuple(
        estimate(value[j], drawn[:, j], round(count[:, j].sum()), int(clusters[j])) for j in range(count.shape[1])
    )
    return estimates, drawn
