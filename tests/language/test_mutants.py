"""One mistake, one message: a sample of the mutants of `benchmarks/mutate.py`, with somewhat looser bounds."""

from collections import Counter

import pytest

from benchmarks.mutate import SPELLED, checked, measured, specs


@pytest.mark.parametrize("count", [15, pytest.param(120, marks=pytest.mark.slow)])
def test_mistake_is_reported_once_at_its_place_with_a_remedy(count: int) -> None:
    outcomes = [o for o in measured(range(10_000, 10_000 + count)) if o.errors]
    reported = Counter[str]()
    for o in outcomes:
        reported["one"] += len(o.errors) == 1
        reported["line"] += o.located
    spelled = [o for o in outcomes if o.mutant.kind in SPELLED]
    assert len(outcomes) > 0.83 * count
    assert len(spelled) > 0.25 * count
    assert reported["one"] >= 0.93 * len(outcomes)
    assert reported["line"] >= 0.93 * len(outcomes)
    assert sum(o.fixed for o in spelled) >= 0.8 * len(spelled)


@pytest.mark.parametrize("every", [32, pytest.param(1, marks=pytest.mark.slow)])
def test_rest_is_checked_without_any_one_word(every: int) -> None:
    """A word that is put in, in thought, is one that the checker can read."""
    for spec in specs()[:12:6]:
        for i, token in enumerate(spec.tokens):
            if i % every == 0:
                assert len(checked(spec.mutant("left out", i, "").text)) < 12, token
