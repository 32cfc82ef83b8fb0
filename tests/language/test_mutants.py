"""One mistake, one message: a sample of the mutants of `benchmarks/mutate.py`, with somewhat looser bounds."""

from collections import Counter

from benchmarks.mutate import SPELLED, measured


def test_a_mistake_is_told_once_where_it_is_and_with_what_mends_it() -> None:
    outcomes = [o for o in measured(range(10_000, 10_250)) if o.errors]
    told = Counter[str]()
    for o in outcomes:
        told["one"] += len(o.errors) == 1
        told["line"] += o.located
    spelled = [o for o in outcomes if o.mutant.kind in SPELLED]
    assert len(outcomes) > 200
    assert len(spelled) > 60
    assert told["one"] >= 0.93 * len(outcomes)
    assert told["line"] >= 0.93 * len(outcomes)
    assert sum(o.mended for o in spelled) >= 0.8 * len(spelled)
