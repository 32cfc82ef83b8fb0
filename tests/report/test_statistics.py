"""Every analysis finds what was put into the raters, and not what was not."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from numpy.typing import NDArray

from tests.report.conftest import LAPSE, STEEP, THRESHOLD, Made, seer
from tests.report.made import Rater, answers
from wmspec.eval.report.choices import kind_of_change
from wmspec.eval.report.compare import Strata, comparisons, weights_in_average
from wmspec.eval.report.curves import curves, strength
from wmspec.eval.report.entanglement import dimension_of_values, relative_entanglement
from wmspec.eval.report.filtered import ALL_MODELS, OWN_PERCEPTION, filtered_accuracies, missed_accuracies
from wmspec.eval.report.intervals import mean_estimates, seeded_generator
from wmspec.eval.report.items import fit_item_response, item_rest_correlation, stratified_sample
from wmspec.eval.report.questions import Questions
from wmspec.eval.report.replies import replies
from wmspec.eval.report.tables import tables
from wmspec.eval.report.whole_groups import whole_groups

# ---------------------------------------------------------------- intervals


def test_intervals_hold_what_is_true_as_often_as_they_say() -> None:
    """160 questions in 40 clusters: 95 % of the intervals hold the mean, 87 % if clusters were ignored."""

    def coverage(trials: int, cluster: NDArray[np.intp]) -> float:
        covered = 0
        for trial in range(trials):
            random = seeded_generator("coverage", trial)
            easy = np.repeat(random.beta(2, 1, 40), 4)
            right = (random.random(160) < easy).astype(float)[:, None]
            (estimate,), _ = mean_estimates(right, cluster, trial)
            assert estimate.low is not None
            assert estimate.high is not None
            covered += estimate.low <= 2 / 3 <= estimate.high
        return covered / trials

    together = coverage(200, np.repeat(np.arange(40), 4))
    assert 0.9 < together < 0.985
    assert coverage(60, np.arange(160)) < together - 0.03


def test_intervals_do_not_move_when_another_system_or_task_is_added() -> None:
    values = (seeded_generator("x").random((200, 3)) < 0.5).astype(float)
    cluster = np.arange(200) // 4
    assert mean_estimates(values, cluster, "task")[0][:2] == mean_estimates(values[:, :2], cluster, "task")[0]


def test_too_few_clusters_have_no_interval() -> None:
    (estimate,), _ = mean_estimates(np.array([[1.0], [0.0], [1.0]]), [0, 0, 1], "few")
    assert (estimate.value, estimate.low, estimate.questions) == (pytest.approx(2 / 3), None, 3)


def test_intervals_do_not_collapse_where_all_is_right() -> None:
    """A system that is right in 95 % of groups is right in all 12 in half of the trials, which intervals allow for."""
    for bound in (0.0, 1.0):
        (one,), drawn = mean_estimates(np.full((48, 1), bound), np.arange(48) // 4, "all")
        assert one.value == bound
        assert one.low is not None
        assert one.high is not None
        assert 0.1 < one.high - one.low < 0.3
        assert drawn.std() > 0
    held = 0
    for trial in range(300):
        right = np.repeat(seeded_generator("bound", trial).random(12) < 0.95, 4).astype(float)[:, None]
        (one,), _ = mean_estimates(right, np.arange(48) // 4, trial)
        held += (one.low or 0) <= 0.95 <= (one.high or 0)
    assert held > 0.93 * 300


# ---------------------------------------------------------------- comparisons


def test_a_better_system_is_better_and_equal_ones_are_not(made: Made) -> None:
    same = [Rater("one", lambda row: 0.7), Rater("two", lambda row: 0.7), Rater("worse", lambda row: 0.6)]
    read = replies(answers([row for row in made.rows if row["task"] != "roll"], *same))
    found = {(c.first, c.second): c for c in comparisons(read) if c.kind == "perception"}
    better, luck = found["one", "worse"], found["one", "two"]
    assert better.difference.value == pytest.approx(0.1, abs=0.03)
    assert better.corrected is not None
    assert better.corrected < 0.001
    assert luck.corrected is not None
    assert luck.corrected > 0.05
    assert luck.p is not None
    assert luck.corrected >= luck.p
    averages = {line.system: line.average.value for line in tables(read)[0].lines}
    assert better.difference.value == pytest.approx(averages["one"] - averages["worse"])
    assert better.first_only > better.second_only


def test_comparison_has_its_nominal_error_rate() -> None:
    """Two tasks of very different sizes; equal systems differ at p < 0.05 in about 5 % of 400 trials."""
    about = pd.DataFrame({
        "task": ["a"] * 40 + ["b"] * 200,
        "dimension": "perception.vision.color",
        "cluster": [f"a/{i // 4}" for i in range(40)] + [f"b/{i // 4}" for i in range(200)],
    })  # fmt: skip
    assert weights_in_average(about) @ (about["task"] == "a") == pytest.approx(0.5)
    found, strata = 0, Strata.of(about)
    for trial in range(400):
        random = seeded_generator("comparison", trial)
        shared = np.repeat(random.normal(0, 0.3, 60), 4)
        _, p = strata.robust_mean(shared + random.normal(0, 0.5, 240))
        assert p is not None
        found += p < 0.05
    assert 0.02 < found / 400 < 0.09


# ---------------------------------------------------------------- choices


def test_position_bias_shows_by_place_and_by_permutation(made: Made) -> None:
    places = {p.place: p for p in made.report.positions if (p.system, p.options) == ("first", 4)}
    assert places[0].accuracy.value == 1.0
    assert places[2].accuracy.value == pytest.approx(0.4, abs=0.06)
    assert places[0].chosen > 0.6
    flips = {f.system: f for f in made.report.flips if not f.task}
    assert set(flips) == {"first", "sure"}
    assert flips["sure"].flips.value == 0
    # The same only if it knows twice, or guesses once where the truth is first: never twice, the options having moved
    # on.
    assert flips["first"].flips.value > 0.4
    assert flips["first"].always < flips["first"].accuracy < flips["sure"].always == 1.0


def test_pairs_count_only_if_both_are_right(made: Made) -> None:
    found = {(p.task, p.system): p for p in made.report.pairs}
    for task in ("race", "tally", "roll"):
        ideal = found[task, "ideal"]
        assert ideal.both.value == pytest.approx(0.8**2, abs=0.09)
        assert ideal.single == pytest.approx(0.8, abs=0.06)
        assert found[task, "sure"].both.value == 1.0
    assert found["race", "first"].chance == pytest.approx(1 / 4)
    assert found["roll", "first"].chance == pytest.approx(1 / 16)


def test_a_whole_group_counts_only_if_all_its_members_are_right(made: Made) -> None:
    """Races as quadruples of possible and impossible episodes: two ratios, and either ball is the faster one."""
    quadruples = [
        row
        for row in made.rows
        if row["task"] == "race" and row["factor.color"] == "red" and row["factor.form"] == "sphere"
        and row["factor.ratio"] in (1.1, 3)
    ]  # fmt: skip
    words = {"upper": "possible", "lower": "impossible"}
    known = made.replies.questions
    assert known is not None
    table = known.table.loc[[row["id"] for row in quadruples]].copy()
    table["names"] = [("possible", "impossible")] * len(table)
    table["truth"] = table["truth"].map(words)
    raters = (
        Rater("ideal", lambda row: 0.8),
        Rater("sure", lambda row: 1.0),
        Rater("says yes", lambda row: 1.0 * (row["answer_value"] == "upper")),
    )
    found = {g.system: g for g in whole_groups(replies(answers(quadruples, *raters), replace(known, table=table)))}
    assert found["ideal"].whole.value == pytest.approx(0.8**4, abs=0.25)
    assert found["sure"].whole.value == 1.0
    assert (found["says yes"].whole.value, found["says yes"].single) == (0.0, 0.5)
    assert {(g.members, g.chance, g.whole.questions) for g in found.values()} == {(4.0, 1 / 16, 10)}
    assert not made.report.whole_groups, "no task of these asks whether something is possible"


def test_pairs_of_a_prediction_are_those_whose_outcomes_were_made_by_what_differs(made: Made) -> None:
    """Only `pace` changes what the counterfactuals change: another colour makes no pair. 4 paces are 6 pairs."""
    assert {p.both.questions for p in made.report.pairs if p.task == "roll" and p.system == "ideal"} == {3 * 20 * 6}


def test_wrong_predictions_are_classified_by_the_changed_factor(made: Made) -> None:
    chosen = {(m.system, m.changed): m for m in made.report.mistaken}
    assert chosen["confused", "action"].chosen > 0.95
    assert chosen["ideal", "action"].chosen == pytest.approx(2 / 3, abs=0.12)
    for mistake in made.report.mistaken:
        assert mistake.offered == pytest.approx({"action": 2 / 3, "state": 1 / 3}[mistake.changed])


@pytest.mark.parametrize(
    ("said", "what"),
    [
        ("action push.speed: 1 m/s -> 2 m/s", "action"),
        ("without push", "action"),
        ("order push, pull", "action"),
        ("state ball.size: 1 cm -> 2 cm", "state"),
        ("action push.speed: 1 -> 2; state ball.size: 1 -> 2", "both"),
        ("weather: sun -> rain", "other"),
        (None, ""),
    ],
)
def test_sources_of_a_change(said: str | None, what: str) -> None:
    assert kind_of_change(said) == what


# ---------------------------------------------------------------- entanglement


def test_entanglement_is_found_exactly_where_it_is(made: Made) -> None:
    found = {(e.system, e.task, e.factor): e for e in made.report.entanglement}
    for task in ("race", "tally"):
        red = found["entangled", task, "color"]
        assert red.dimension == "color"
        assert not red.probed
        # One of four levels at half the others' accuracy: |1 - p/p̄| are 3/7, 1/7, 1/7, 1/7.
        assert red.value == pytest.approx(3 / 14, abs=0.05)
        assert red.p < 0.01
        assert red.value > 2 * red.bound
        ideal = found["ideal", task, "color"]
        assert ideal.value < 0.06
        assert ideal.p > 0.01
    shapes = found["entangled", "race", "form"]
    assert shapes.dimension == "shape"
    assert shapes.p > 0.01


def test_factor_of_the_question_is_not_entangled(made: Made) -> None:
    requested = {(e.task, e.question, e.factor) for e in made.report.entanglement if e.probed}
    assert requested == {("race", "", "ratio"), ("race", "", "faster"), ("roll", "", "pace"), ("tally", "", "n")}


def test_sre_is_the_papers_formula() -> None:
    codes, scores = np.array([0, 0, 1, 1, 2, 2]), np.array([[1, 1, 1, 0, 0, 0]], dtype=float).T
    assert relative_entanglement(codes, scores)[0] == pytest.approx((1 + 0 + 1) / 3)
    assert np.isnan(relative_entanglement(codes, np.zeros((6, 1))))[0]


@pytest.mark.parametrize(
    ("levels", "which"),
    [
        (["red", "blue"], "color"),
        (["cube", "sphere"], "shape"),
        (["wood", "metal"], "material"),
        (["0.1", "0.2"], ""),
        (["upper", "lower"], ""),
    ],
)
def test_words_show_the_dimension_of_a_factor_where_a_dataset_records_none(levels: list[str], which: str) -> None:
    import pandas as pd

    assert dimension_of_values(pd.Series(levels)) == which


def test_factors_are_of_the_dimension_that_the_spec_gives_them(made: Made) -> None:
    assert made.replies.questions is not None
    about = made.replies.questions.about
    assert all(e.dimension == about[e.task][e.factor] for e in made.report.entanglement)
    assert {e.dimension for e in made.report.entanglement} >= {"color", "shape"}


# ---------------------------------------------------------------- curves


def test_a_known_threshold_is_found_within_its_interval(made: Made) -> None:
    curve = next(c for c in made.report.curves if (c.system, c.task) == ("seer", "race"))
    assert curve.scale == "log"
    assert curve.chance == pytest.approx(0.5)
    assert curve.low is not None
    assert curve.high is not None
    assert curve.low < THRESHOLD < curve.high
    assert curve.high / curve.low < 1.3
    truth = 0.5 + (0.5 - LAPSE) / (1 + np.exp(-STEEP * (np.log2([1.25, 2.5]) - np.log2(THRESHOLD))))
    assert curve.at(np.array([1.25, 2.5])) == pytest.approx(truth, abs=0.05)
    people = next(c for c in made.report.curves if (c.system, c.task) == ("people", "race"))
    assert people.high is not None
    assert people.high < curve.low


def test_flat_curve_has_no_threshold(made: Made) -> None:
    flat = [c for c in made.report.curves if c.system in ("ideal", "random")]
    assert len(flat) == 4
    assert all(c.threshold is None and c.flat is not None and c.flat > 0.05 for c in flat)


def test_thresholds_are_covered_as_often_as_they_say(made: Made) -> None:
    race = [row for row in made.rows if row["task"] == "race" and row["block"] < 6]
    raters = [Rater(f"r{i}", seer(1.7)) for i in range(20)]
    found = curves(replies(answers(race, *raters), Questions.read(made.folder)))
    held = [c.low is not None and c.high is not None and c.low < 1.7 < c.high for c in found]
    assert len(held) == 20
    assert sum(held) >= 18


def test_ratio_counts_from_one_and_equality_is_excluded() -> None:
    assert strength("speed(a) / speed(b)", np.array([2.0, 0.5]))[0] == pytest.approx([2, 2])
    assert np.isnan(strength("speed(a) / speed(b)", np.array([1.0, 0.0]))[0]).all()
    assert strength("onset(a) - onset(b)", np.array([-3.0, 3.0]))[0] == pytest.approx([3, 3])
    assert np.isnan(strength("onset(a) - onset(b)", np.array([0.0]))[0]).all()


# ---------------------------------------------------------------- filtered prediction


def test_known_gain_is_found_and_no_other(made: Made) -> None:
    found = {(f.system, f.by): f for f in made.report.filtered}
    gain = found["foresees", OWN_PERCEPTION]
    # 85 % where it perceives, 25 % where not: 65 % of all; two thirds are left.
    assert gain.kept == pytest.approx(2 / 3)
    assert gain.everything.value == pytest.approx(0.65, abs=0.05)
    assert gain.perceived.value == pytest.approx(0.85, abs=0.05)
    assert gain.gain.low is not None
    assert gain.gain.high is not None
    assert 0.1 < gain.gain.low < 0.2 < gain.gain.high < 0.3
    none = found["ideal", OWN_PERCEPTION].gain
    assert none.low is not None
    assert none.high is not None
    assert none.low < 0 < none.high
    assert found["sure", OWN_PERCEPTION].kept == 1.0
    assert found["ideal", ALL_MODELS].kept < 0.2


def test_a_system_that_ignores_the_mover_leaves_the_filtered_score(made: Made) -> None:
    """It predicts well by the options alone, and cannot answer companion questions."""
    ignores = Rater("ignores", lambda row: 0.0 if row["question_name"] == "color" else 0.8)
    read = replies(answers(made.rows, ignores), Questions.read(made.folder))
    (own,) = (f for f in filtered_accuracies(read) if f.by == OWN_PERCEPTION)
    assert own.everything.value > 0.7
    assert own.kept == 0.0
    assert np.isnan(own.perceived.value)


def test_the_gain_is_found_by_the_question_that_was_missed(made: Made) -> None:
    found = {(m.system, m.missed): m for m in missed_accuracies(made.replies)}
    missed = found["foresees", "color"]
    # 25 % where it does not tell the colour, 65 % of all; a third is that.
    assert missed.share == pytest.approx(1 / 3)
    assert missed.accuracy.value == pytest.approx(0.25, abs=0.07)
    assert missed.gain.high is not None
    assert missed.gain.high < -0.25
    assert ("foresees", "moves") not in found, "it never misses whether something moves"
    other = found["ideal", "color"].gain
    assert other.low is not None
    assert other.high is not None
    assert other.low < 0 < other.high


# ---------------------------------------------------------------- items


def test_difficulty_and_ability_are_recovered() -> None:
    random = seeded_generator("items")
    theta, b = random.normal(0, 1, 15), random.normal(0, 1, 600)
    guess = np.full(600, 0.25)
    p = 0.25 + 0.75 / (1 + np.exp(-1.3 * (theta - b[:, None])))
    ability, difficulty = fit_item_response((random.random((600, 15)) < p).astype(float), guess)
    assert np.corrcoef(ability, theta)[0, 1] > 0.97
    assert np.corrcoef(difficulty, b)[0, 1] > 0.7


def test_wrong_labels_are_among_the_suspects() -> None:
    random = seeded_generator("labels")
    theta, b = random.normal(0, 1.2, 15), random.normal(0, 1, 500)
    right = (random.random((500, 15)) < 1 / (1 + np.exp(-1.5 * (theta - b[:, None])))).astype(float)
    right[:10] = 1 - right[:10]
    worst = np.argsort(np.nan_to_num(item_rest_correlation(right)))[:20]
    assert np.isin(np.arange(10), worst).sum() >= 6


def test_a_short_form_is_better_than_a_random_one_of_unequal_tasks(made: Made) -> None:
    items = made.report.items
    assert items is not None
    errors = {f.size: f for f in items.forms}
    assert errors[200].error < errors[10].error
    assert sum(f.error < f.at_random for f in items.forms) >= len(items.forms) / 2
    assert sum(n for _, n in items.short) in errors


def test_a_sample_takes_one_of_every_piece_of_equal_weight() -> None:
    taken = stratified_sample(np.arange(100), np.ones(100), 10, np.full(10, 0.45))
    assert list(taken) == list(range(4, 100, 10))


def test_too_few_systems_have_no_items(made: Made) -> None:
    from wmspec.eval.report.items import items

    assert items(replies(answers(made.rows[:200], Rater("a", lambda row: 0.5), Rater("b", lambda row: 0.7)))) is None
