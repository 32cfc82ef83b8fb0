"""The statistics are those of scipy and of the textbooks; the classifier finds what is there and nothing else."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import stats

from wmspec.audit.classify import held_out
from wmspec.audit.statistics import clopper_pearson, goodness, holm, independence


def test_a_large_table_has_the_chi_square_of_scipy() -> None:
    table = np.array([[30, 14, 6], [10, 25, 15]])
    strength, p, method = independence(table)
    assert p == pytest.approx(stats.chi2_contingency(table, correction=False).pvalue)
    assert strength == pytest.approx(stats.contingency.association(table))
    assert method == "chi-square"


def test_a_small_table_is_tested_exactly() -> None:
    table = np.array([[8, 2], [1, 5]])  # Fisher's tea: p = 0.0350 (Agresti 2013, two-sided)
    assert independence(table)[1:] == (pytest.approx(0.03497, abs=1e-5), "Fisher's exact")
    wide = np.array([[4, 0, 1], [0, 5, 1]])
    assert independence(wide)[1] == pytest.approx(_every_table(wide), abs=0.005)


def _every_table(table: np.ndarray) -> float:
    """The probability of a chi-square at least as large, from all 2 x 3 tables with the same margins."""
    rows, columns = table.sum(1), table.sum(0)
    drawn, expected = stats.random_table(rows, columns), np.outer(rows, columns) / table.sum()

    def far(t: np.ndarray) -> float:
        return float(((t - expected) ** 2 / expected).sum())

    total = 0.0
    for a in range(rows[0] + 1):
        for b in range(rows[0] + 1 - a):
            top = np.array([a, b, rows[0] - a - b])
            if (top <= columns).all() and far(every := np.array([top, columns - top])) >= far(table) - 1e-9:
                total += float(drawn.pmf(every))
    return total


def test_what_does_not_vary_goes_with_nothing() -> None:
    assert independence(np.array([[5, 5], [0, 0]])) == (0.0, 1.0, "nothing varies")


def test_tests_of_nothing_reject_as_often_as_they_say() -> None:
    random = np.random.default_rng(0)
    small = [independence(_table(random, 18))[1] for _ in range(300)]
    large = [independence(_table(random, 200))[1] for _ in range(300)]
    for p in (small, large):
        assert np.mean(np.array(p) < 0.05) < 0.09


def _table(random: np.random.Generator, count: int) -> np.ndarray:
    table = np.zeros((2, 3), dtype=np.int64)
    np.add.at(table, (random.integers(2, size=count), random.integers(3, size=count)), 1)
    return table


def test_goodness_of_fit() -> None:
    counts, expected = np.array([30, 50, 40]), np.full(3, 40.0)
    assert goodness(counts, expected)[1] == pytest.approx(stats.chisquare(counts).pvalue)
    assert goodness(np.array([1, 7]), np.full(2, 4.0))[1] == pytest.approx(stats.binomtest(1, 8).pvalue)
    assert goodness(np.array([9, 0, 0]), np.full(3, 3.0))[1] < 0.001


def test_holm_by_hand() -> None:
    assert holm([0.01, 0.04, 0.03, 0.005]) == pytest.approx([0.03, 0.06, 0.06, 0.02])
    assert holm([]) == []


@pytest.mark.parametrize("right", [0, 3, 20])
def test_the_interval_is_the_exact_one(right: int) -> None:
    there = stats.binomtest(right, 20).proportion_ci(0.95, "exact")
    assert clopper_pearson(right, 20, 0.95) == pytest.approx((there.low, there.high))


def _options(count: int, of: int) -> tuple[np.ndarray, np.ndarray, list[str], np.random.Generator]:
    random = np.random.default_rng(1)
    owner = np.repeat(np.arange(count), of)
    truth = (np.arange(of) == random.integers(of, size=count)[:, None]).ravel()
    return owner, truth, [str(i) for i in range(count)], random


def test_noise_is_answered_by_chance_and_a_clue_is_not() -> None:
    owner, truth, groups, random = _options(400, 4)
    noise = random.normal(size=(1600, 300))
    low, high = clopper_pearson(held_out(noise, owner, truth, groups).sum(), 400, 0.99)
    assert low < 0.25 < high
    clue = np.c_[noise, 4 * truth + random.normal(size=1600)]
    assert held_out(clue, owner, truth, groups).mean() > 0.8


def test_options_that_cannot_be_told_apart_count_as_a_guess() -> None:
    owner, truth, groups, _ = _options(40, 4)
    assert held_out(np.ones((160, 2)), owner, truth, groups) == pytest.approx(np.full(40, 0.25))


def test_what_is_known_of_a_group_does_not_help_with_that_group() -> None:
    owner, truth, _, random = _options(300, 2)
    group = np.repeat(np.arange(30), 10)
    lucky = random.integers(2, size=30)[group]  # in each group the truth stands where the others of the group have it
    truth = (np.arange(2) == lucky[:, None]).ravel()
    features = np.zeros((600, 60))
    features[np.arange(600), np.repeat(group, 2) * 2 + np.tile([0, 1], 300)] = 1
    assert held_out(features, owner, truth, [f"g{g}" for g in group]).mean() == pytest.approx(0.5)
    assert held_out(features, owner, truth, [str(i) for i in range(300)]).mean() > 0.95
