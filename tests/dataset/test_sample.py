"""The power of random samples, against the hypergeometric distribution."""

from __future__ import annotations

import math

from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import hypergeom

from wmspec.dataset.verify.marks import OptionScores, marked_truths, tail
from wmspec.dataset.verify.sample import FOUND, SHARE, draw, found, sample_size


@given(st.integers(1, 5000), st.integers(0, 200))
def test_the_probability_is_hypergeometric(population: int, drawn: int) -> None:
    drawn = min(drawn, population)
    changed = math.ceil(SHARE * population)
    expected = 1 - hypergeom(population, changed, drawn).pmf(0)
    assert math.isclose(found(population, drawn), expected, abs_tol=1e-9)


@given(st.integers(1, 20_000))
def test_the_default_sample_is_the_smallest_with_its_power(population: int) -> None:
    size = sample_size(population)
    assert found(population, size) >= FOUND
    assert size == 1 or found(population, size - 1) < FOUND
    assert size <= 90


def test_a_sample_depends_on_its_seed_and_has_no_item_twice() -> None:
    items = list(range(1000))
    samples = [draw(items, 90, seed, "rows") for seed in (1, 1, 2)]
    assert samples[0] == samples[1] != samples[2]
    assert len(set(samples[0])) == 90


def test_a_mark_on_the_truth_is_found_and_noise_is_not() -> None:
    noise = [OptionScores([0.1 * ((7 * q + o) % 13) for o in range(4)], q % 4) for q in range(40)]
    assert not list(marked_truths(noise))
    marked = [OptionScores([s + (o == q.answer) for o, s in enumerate(q.scores)], q.answer) for q in noise]
    (found_mark,) = marked_truths(marked[:20])
    assert "differs more than the others" in found_mark.words


@given(st.integers(1, 30), st.integers(2, 6))
def test_the_tail_is_binomial(trials: int, options: int) -> None:
    assert math.isclose(tail([1 / options] * trials, trials), options**-trials, rel_tol=1e-6)
