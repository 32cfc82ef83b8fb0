"""Two datasets that measure the same rank the models alike; two that do not, do not."""

from __future__ import annotations

import pytest
from scipy.stats import kendalltau, spearmanr

from tests.report.conftest import Made
from tests.report.made import Knows, Rater, answers
from wmspec.eval.report.ranks import rank_agreement
from wmspec.eval.report.replies import Replies, replies


def results(made: Made, abilities: dict[str, float], salt: str) -> Replies:
    def able(p: float) -> Knows:
        return lambda row: p

    raters = [Rater(f"{salt}{name}", able(p)) for name, p in abilities.items()]
    table = answers([row for row in made.rows if row["index"] % 4 == 1], *raters)
    return replies(table.assign(model=table["model"].str.removeprefix(salt)))


ABLE = {"a": 0.45, "b": 0.55, "c": 0.65, "d": 0.75, "e": 0.85}


@pytest.fixture(scope="module")
def first(made: Made) -> Replies:
    return results(made, ABLE, "1")


def test_equal_abilities_are_ranked_alike_and_turned_ones_are_not(made: Made, first: Replies) -> None:
    same = results(made, ABLE, "2")
    turned = results(made, dict(zip(ABLE, reversed(ABLE.values()), strict=True)), "3")
    for other, expected in ((same, 1.0), (turned, -1.0)):
        whole = rank_agreement(first, other)[0]
        assert whole.kind == ""
        assert whole.spearman.value == pytest.approx(expected)
        assert whole.kendall.value == pytest.approx(expected)
        assert whole.spearman.low is not None
        assert whole.spearman.high is not None
        assert whole.spearman.low <= whole.spearman.value <= whole.spearman.high


def test_the_correlations_are_those_of_scipy(made: Made, first: Replies) -> None:
    near = dict.fromkeys(ABLE, 0.6)
    for found in rank_agreement(first, results(made, near, "4")):
        assert found.spearman.value == pytest.approx(spearmanr(found.first, found.second).statistic)
        assert found.kendall.value == pytest.approx(kendalltau(found.first, found.second).statistic)
        assert found.kendall.low is not None
        assert found.kendall.high is not None
        assert found.kendall.high - found.kendall.low > 0.3, "equal models have no sure ranks"


def test_few_models_have_no_ranks(made: Made) -> None:
    two = results(made, {"a": 0.5, "b": 0.6}, "5")
    assert rank_agreement(two, two) == ()
