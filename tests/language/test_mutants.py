"""One mistake, one message: a sample of the mutants of `benchmarks/mutate.py`, with somewhat looser bounds."""

from collections import Counter

from benchmarks.mutate import SPELLED, checked, measured, specs


def test_a_mistake_is_told_once_where_it_is_and_with_what_mends_it() -> None:
    outcomes = [o for o in measured(range(10_000, 10_120)) if o.errors]
    told = Counter[str]()
    for o in outcomes:
        told["one"] += len(o.errors) == 1
        told["line"] += o.located
    spelled = [o for o in outcomes if o.mutant.kind in SPELLED]
    assert len(outcomes) > 100
    assert len(spelled) > 30
    assert told["one"] >= 0.93 * len(outcomes)
    assert told["line"] >= 0.93 * len(outcomes)
    assert sum(o.mended for o in spelled) >= 0.8 * len(spelled)


def test_whatever_word_is_left_out_the_rest_is_checked() -> None:
    """A word that is put in, in thought, is one that the checker can read."""
    for spec in specs()[:12:6]:
        for i, token in enumerate(spec.tokens):
            assert len(checked(spec.mutant("left out", i, "").text)) < 12, token
