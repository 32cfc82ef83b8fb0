"""Statistics of the audit: tests of independence, correction for multiple tests, exact intervals."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import optimize, stats

Table = NDArray[np.int64]

#: Minimum expected count of every cell for the chi-square distribution (Cochran 1954).
MIN_EXPECTED = 5
#: Number of random tables with the same margins where no exact formula is available.
RANDOM_TABLES = 19_999
SEED = 20_611


def independence(table: Table) -> tuple[float, float, str]:
    """Return Cramér's V of a contingency table, its p-value, and the method.

    Chi-square where every cell is expected to hold 5. Otherwise Fisher's exact test for 2 x 2, and random tables with
    the same margins (Patefield 1981) for larger ones. (0, 1, "nothing varies") where a margin has a single value.
    """
    table = table[table.sum(1) > 0][:, table.sum(0) > 0]
    if min(table.shape) < 2:
        return 0.0, 1.0, "nothing varies"
    expected = np.outer(table.sum(1), table.sum(0)) / table.sum()
    seen = pearson(table)
    strength = float(np.sqrt(seen / table.sum() / (min(table.shape) - 1)))
    if expected.min() >= MIN_EXPECTED:
        return strength, float(stats.chi2.sf(seen, (table.shape[0] - 1) * (table.shape[1] - 1))), "chi-square"
    if table.shape == (2, 2):
        return strength, float(stats.fisher_exact(table).pvalue), "Fisher's exact"
    drawn = stats.random_table(table.sum(1), table.sum(0)).rvs(RANDOM_TABLES, random_state=SEED)
    return strength, _rank(seen, pearson(drawn)), f"{RANDOM_TABLES:,} random tables"


def dependence(
    first: NDArray[np.intp], second: NDArray[np.intp], groups: NDArray[np.intp]
) -> tuple[float, float, str, float]:
    """Return the results of `independence` for two coded variables (n,), and the design effect.

    A variable that is constant within groups is permuted between groups, so that each group counts as one observation.
    The p-value comes from this permutation test. The design effect (Kish 1965) is the number of cases worth one
    independent case, at least 1.
    """
    table = contingency_table(first, second)
    by_group = np.unique(groups, return_index=True)[1]
    dealt = next((one for one in (second, first) if np.array_equal(one, one[by_group][groups])), None)
    if dealt is None or len(by_group) == len(groups) or min(table.shape) < 2:
        return *independence(table), 1.0
    other, levels = first if dealt is second else second, dealt[by_group]
    held, order = contingency_table(groups, other).astype(np.float32), _orders(len(by_group))
    drawn = np.stack([(levels == level)[order].astype(np.float32) @ held for level in range(dealt.max() + 1)], axis=-2)
    chance, seen = pearson(drawn.astype(np.float64)), pearson(table)
    narrow = min(table.shape) - 1
    effect = max(1.0, float(chance.mean()) / narrow / (max(table.shape) - 1))
    strength = float(np.sqrt(seen / len(groups) / narrow))
    return strength, _rank(seen, chance), f"dealt to {len(by_group):,} groups {RANDOM_TABLES:,} times", effect


def contingency_table(first: NDArray[np.intp], second: NDArray[np.intp]) -> Table:
    """Return the contingency table of two coded variables (n,); rows are values of the first."""
    table = np.zeros((first.max() + 1, second.max() + 1), np.int64)
    np.add.at(table, (first, second), 1)
    return table


def goodness_of_fit(counts: NDArray[np.int64], expected: NDArray[np.float64]) -> tuple[float, float, str]:
    """Return Cohen's w of counts against expected ones, the p-value, and the method."""
    if len(counts) < 2:
        return 0.0, 1.0, "nothing varies"
    total = int(counts.sum())
    seen = ((counts - expected) ** 2 / expected).sum()
    strength = float(np.sqrt(seen / total))
    if expected.min() >= MIN_EXPECTED:
        return strength, float(stats.chi2.sf(seen, len(counts) - 1)), "chi-square"
    if len(counts) == 2:
        return strength, float(stats.binomtest(int(counts[0]), total, expected[0] / total).pvalue), "exact binomial"
    drawn = np.random.default_rng(SEED).multinomial(total, expected / total, RANDOM_TABLES)
    return strength, _rank(seen, ((drawn - expected) ** 2 / expected).sum(1)), f"{RANDOM_TABLES:,} random draws"


def detectable(counts: Sequence[Sequence[int]], level: float, effect: float = 1.0, power: float = 0.8) -> float:
    """Return the strength (Cramér's V, Cohen's w) that a chi-square test at this level detects with this power, at most
    1.

    Uses the noncentral chi-square distribution (Cohen 1988); a table with one row is a test of goodness of fit.
    `effect` is the design effect.
    """
    table = np.array(counts)
    rows, columns = (table.sum(1) > 0).sum(), (table.sum(0) > 0).sum()
    freedom = columns - 1 if len(table) == 1 else (rows - 1) * (columns - 1)
    if freedom < 1:
        return 0.0
    critical = stats.chi2.isf(level, freedom)
    far = optimize.brentq(lambda x: stats.ncx2.sf(critical, freedom, x) - power, 1e-9, 1e4)
    narrow = 1 if len(table) == 1 else min(rows, columns) - 1
    return min(1.0, float(np.sqrt(far * effect / table.sum() / narrow)))


@lru_cache(maxsize=2)
def _orders(groups: int) -> NDArray[np.intp]:
    """Return permutations of groups (DRAWN, groups); deterministic."""
    return np.random.default_rng(SEED).random((RANDOM_TABLES, groups), np.float32).argsort(axis=1)


def pearson(tables: NDArray[Any]) -> NDArray[np.float64]:
    """Return Pearson's statistic of each table (..., rows, columns); empty margins contribute nothing."""
    rows, columns = tables.sum(-1, keepdims=True), tables.sum(-2, keepdims=True)
    expected = rows * columns / tables.sum((-2, -1), keepdims=True)
    return np.asarray(((tables - expected) ** 2 / np.where(expected, expected, 1.0)).sum((-2, -1)))


def _rank(seen: NDArray[np.float64], drawn: NDArray[np.float64]) -> float:
    """Return the share of random statistics at least as large, counting the observed one."""
    return float((np.sum(drawn >= seen * (1 - 1e-9)) + 1) / (len(drawn) + 1))


def holm(p: Sequence[float]) -> list[float]:
    """Return p-values after Holm's correction (Holm 1979), in the same order."""
    corrected, largest = [1.0] * len(p), 0.0
    for rank, i in enumerate(sorted(range(len(p)), key=lambda i: p[i])):
        largest = max(largest, min(1.0, p[i] * (len(p) - rank)))
        corrected[i] = largest
    return corrected


def clopper_pearson(right: float, count: int, confidence: float) -> tuple[float, float]:
    """Return the exact interval of a proportion (Clopper & Pearson 1934); `right` may be fractional, from ties."""
    tail = (1 - confidence) / 2
    low = float(stats.beta.ppf(tail, right, count - right + 1)) if right > 0 else 0.0
    high = float(stats.beta.isf(tail, right + 1, count - right)) if right < count else 1.0
    return low, high
