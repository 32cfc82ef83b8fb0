"""The statistics are those of scipy and of the textbooks; the classifier finds what is there and nothing else."""

from __future__ import annotations

from dataclasses import replace
from itertools import combinations
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats
from sklearn.ensemble import RandomForestClassifier
from sklearn.model_selection import cross_val_predict

from wmspec.dataset.audit import power
from wmspec.dataset.audit.classify import (
    FEATURE_SHARE,
    FOREST_TREES,
    MIN_LEAF,
    SEED,
    ProbeDataset,
    ProbeFeatures,
    cross_validated_scores,
    nested_scores,
)
from wmspec.dataset.audit.model import Probe
from wmspec.dataset.audit.probe_selection import CandidateProbes
from wmspec.dataset.audit.statistics import clopper_pearson, dependence, detectable, goodness_of_fit, holm, independence


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


def test_constant_variable_depends_on_nothing() -> None:
    assert independence(np.array([[5, 5], [0, 0]])) == (0.0, 1.0, "nothing varies")


def _grouped(random: np.random.Generator, tells: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """40 groups of 12 cases: a level for each group, and answers that are mostly the group's own or tell it."""
    groups = np.repeat(np.arange(40), 12)
    level, own = random.integers(0, 3, 40), random.integers(0, 3, 40)
    answers = np.where(random.random(480) < 0.8, own[groups], random.integers(0, 3, 480))
    return np.where(random.random(480) < tells, level[groups], answers), level[groups], groups


@pytest.mark.parametrize("swapped", [False, True])
def test_cases_of_a_group_are_no_evidence_of_their_own(swapped: bool) -> None:
    """What is dealt to groups: false alarms are rare, where those of who counts cases are the rule."""
    random = np.random.default_rng(0)
    alarms, naive = 0, 0
    for _ in range(60):
        answers, levels, groups = _grouped(random, 0.0)
        reported = dependence(levels, answers, groups) if swapped else dependence(answers, levels, groups)
        assert reported[0] == pytest.approx(independence(_crossed(answers, levels))[0])
        assert 4 < reported[3] < 12
        alarms += reported[1] < 0.05
        naive += independence(_crossed(answers, levels))[1] < 0.05
    assert alarms <= 8  # 3 are to be expected, more than 8 in 4 of 1000 datasets
    assert naive > 30


def test_dependence_within_groups_is_found() -> None:
    answers, levels, groups = _grouped(np.random.default_rng(1), 0.5)
    strength, p, method, effect = dependence(answers, levels, groups)
    assert p < 0.001
    assert (
        strength
        > detectable(_crossed(answers, levels).tolist(), 0.01, effect)
        > detectable(_crossed(answers, levels).tolist(), 0.01)
    )
    assert method == "dealt to 40 groups 19,999 times"


def test_cases_without_groups_are_tested_as_ever() -> None:
    random = np.random.default_rng(2)
    a, b = random.integers(0, 3, (2, 300))
    alone, mixed = np.arange(300), np.arange(300) % 30
    assert dependence(a, b, alone) == dependence(a, b, mixed) == (*independence(_crossed(a, b)), 1.0)


def _crossed(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    table = np.zeros((3, 3), np.int64)
    np.add.at(table, (first, second), 1)
    return table


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
    assert goodness_of_fit(counts, expected)[1] == pytest.approx(stats.chisquare(counts).pvalue)
    assert goodness_of_fit(np.array([1, 7]), np.full(2, 4.0))[1] == pytest.approx(stats.binomtest(1, 8).pvalue)
    assert goodness_of_fit(np.array([9, 0, 0]), np.full(3, 3.0))[1] < 0.001


def test_holm_by_hand() -> None:
    assert holm([0.01, 0.04, 0.03, 0.005]) == pytest.approx([0.03, 0.06, 0.06, 0.02])
    assert holm([]) == []


@pytest.mark.parametrize("right", [0, 3, 20])
def test_the_interval_is_the_exact_one(right: int) -> None:
    there = stats.binomtest(right, 20).proportion_ci(0.95, "exact")
    assert clopper_pearson(right, 20, 0.95) == pytest.approx((there.low, there.high))


def test_detectable_strength_is_detected_at_its_stated_power() -> None:
    random, level = np.random.default_rng(2), 0.01
    strength = detectable(np.full((2, 2), 75).tolist(), level)
    joint = np.array([[1 + strength, 1 - strength], [1 - strength, 1 + strength]]).ravel() / 4
    drawn = (random.multinomial(300, joint).reshape(2, 2) for _ in range(300))
    assert 0.72 < np.mean([stats.chi2_contingency(t, correction=False).pvalue < level for t in drawn]) < 0.88
    assert detectable([[40, 40, 40]], level) > detectable([[400, 400, 400]], level)
    assert detectable([[9, 0]], level) == 0.0, "nothing varies"


# ---------------------------------------------------------------- classifiers


def _questions(count: int, of: int, together: int = 1, seed: int = 1) -> tuple[ProbeDataset, np.random.Generator]:
    """Questions whose true option is drawn, `together` of them in a group."""
    random = np.random.default_rng(seed)
    truth = (np.arange(of) == random.integers(of, size=count)[:, None]).ravel()
    names = np.tile([f"option {i}" for i in range(of)], count)
    return ProbeDataset(
        np.repeat(np.arange(count), of), names, truth, [str(i // together) for i in range(count)]
    ), random


def test_noise_scores_at_chance_and_a_clue_does_not() -> None:
    probed, random = _questions(200, 4)
    for model in ("linear", "forest"):
        right = [
            cross_validated_scores(ProbeFeatures(random.normal(size=(800, 10)), "options", model), probed).sum()
            for _ in range(5)
        ]
        low, high = clopper_pearson(sum(right), 1000, 0.999)
        assert low < 0.25 < high
        noise = random.normal(size=(800, 10))
        clue = np.c_[noise, 4 * probed.truth + random.normal(size=800)]
        assert cross_validated_scores(ProbeFeatures(clue, "options", model), probed).mean() > 0.8


@pytest.mark.parametrize("model", ["linear", "forest"])
def test_whole_question_clue_identifies_options_by_name(model: Any) -> None:
    probed, random = _questions(300, 3)
    true = probed.truth.reshape(300, 3).argmax(1)
    seen = np.c_[random.normal(size=(300, 5)), np.eye(3)[true] + 0.2 * random.normal(size=(300, 3))]
    assert cross_validated_scores(ProbeFeatures(seen, "questions", model), probed).mean() > 0.95


def test_it_equals_scikit_learn() -> None:
    """With two options, what is picked is what scikit-learn's own cross-validation predicts."""
    probed, random = _questions(200, 2, 4)
    side = probed.truth.reshape(200, 2)[:, 0]
    seen = np.c_[random.normal(size=(200, 4)), side + random.normal(size=200)]
    forest = RandomForestClassifier(
        FOREST_TREES, min_samples_leaf=MIN_LEAF, max_features=FEATURE_SHARE, random_state=SEED
    )
    folds = [(np.setdiff1d(np.arange(200), held), held) for held in probed.folds]
    there = cross_val_predict(forest, seen, np.where(side, "option 0", "option 1"), cv=folds, method="predict_proba")
    right = np.where(there[:, 0] == there[:, 1], 0.5, (there[:, 0] > there[:, 1]) == side)
    assert cross_validated_scores(ProbeFeatures(seen, "questions", "forest"), probed) == pytest.approx(right)


def test_indistinguishable_options_count_as_a_guess() -> None:
    probed, _ = _questions(40, 4)
    assert cross_validated_scores(ProbeFeatures(np.ones((160, 2)), "options", "linear"), probed) == pytest.approx(
        np.full(40, 0.25)
    )


def test_folds_keep_groups_together() -> None:
    probed, random = _questions(300, 2, 10)
    lucky = random.integers(2, size=30)[np.arange(300) // 10]  # in each group the truth is where its others have it
    probed = probed.with_labels(lucky)
    features = np.zeros((600, 60))
    features[np.arange(600), np.repeat(np.arange(300) // 10, 2) * 2 + np.tile([0, 1], 300)] = 1
    assert cross_validated_scores(ProbeFeatures(features, "options", "linear"), probed).mean() == pytest.approx(0.5)
    apart = replace(probed, groups=[str(i) for i in range(300)])
    assert cross_validated_scores(ProbeFeatures(features, "options", "linear"), apart).mean() > 0.95


def test_no_group_is_on_both_sides() -> None:
    probed, _ = _questions(200, 2, 7)
    sides = [{probed.groups[i] for i in held} for held in probed.folds]
    assert len(sides) == 5
    assert not any(a & b for a, b in combinations(sides, 2))


# ---------------------------------------------------------------- power


def test_accuracies_of_alike_questions_vary_more() -> None:
    groups = [str(i // 10) for i in range(200)]
    chance = np.full(200, 0.5)
    alone = power.deviation(np.tile([0.0, 1.0], 100), chance, groups)
    assert alone == pytest.approx(power.FOLD_INFLATION * np.sqrt(0.25 / 200))
    assert power.deviation(np.repeat(np.tile([0.0, 1.0], 10), 10), chance, groups) > 3 * alone


def _alarm(seen: ProbeFeatures, probed: ProbeDataset, tests: int) -> bool:
    right = cross_validated_scores(seen, probed)
    chance = 1 / probed.sizes
    above = float((right - chance).mean()) / power.deviation(right, chance, probed.groups)
    return above > power.threshold(tests)


@pytest.mark.parametrize(
    ("of", "model", "draws"),
    [("options", "linear", 30), pytest.param("questions", "forest", 60, marks=pytest.mark.slow)],
)
@pytest.mark.parametrize("choices", [2, 4])
def test_shortcut_of_the_reported_size_is_found_in_four_of_five_draws(
    of: Any, model: Any, draws: int, choices: int
) -> None:
    """A law of the audit: what it says that it would have found, it finds; and where there is nothing, it is silent."""
    probed, random = _questions(400, choices, 4)
    rows, tests, chance = 400 * (choices if of == "options" else 1), 20, 1 / probed.sizes

    def blank() -> ProbeFeatures:
        return ProbeFeatures(random.normal(size=(rows, 8)), of, model)

    seen = blank()
    spread = power.deviation(cross_validated_scores(seen, probed), chance, probed.groups)
    probe = _probe(1 / choices, spread, power.learned_gains(seen, probed, chance))
    size = power.smallest_detectable(probe, power.threshold(tests))
    assert 0.08 < size < 0.3
    found = [_alarm(*power.inject_shortcut(blank(), probed, size, random), tests) for _ in range(draws)]
    false = [_alarm(blank(), _questions(400, choices, 4, seed)[0], 1) for seed in range(draws)]
    assert stats.binomtest(sum(found), draws, 0.8, alternative="less").pvalue > 0.01, np.mean(found)
    assert stats.binomtest(sum(false), draws, power.FALSE_ALARMS, alternative="greater").pvalue > 0.01


def _rivals(
    probed: ProbeDataset, random: np.random.Generator, reported: float = 0.0, count: int = 8
) -> tuple[CandidateProbes, ProbeDataset]:
    """Probes that see noise, and the questions; the first one sees a shortcut of size `told`."""
    seen = [ProbeFeatures(random.normal(size=(len(probed.owner), 8)), "options", "forest") for _ in range(count)]
    if reported:
        seen[0], probed = power.inject_shortcut(seen[0], probed, reported, random)
    return CandidateProbes.of([lambda s=s: s for s in seen], probed), probed  # type: ignore[misc]


def test_best_probe_is_selected_and_scored_on_held_out_answers() -> None:
    probed, random = _questions(160, 2, 4)
    rivals, probed = _rivals(probed, random, 0.4, 4)
    right, picked = rivals.best(probed)
    assert set(picked) == {0}
    assert right == pytest.approx(rivals.right[0])
    assert right.mean() > 0.8


def test_selection_never_sees_the_held_out_fold() -> None:
    """If the truths of a fold are others, all that picks for it, and all that is fitted to judge it, stays the same."""
    probed, random = _questions(80, 2, 4)
    seen = ProbeFeatures(random.normal(size=(160, 4)), "options", "forest")
    places = probed.truth.reshape(80, 2).argmax(1)
    for fold, held in list(enumerate(probed.folds))[:2]:
        turned = places.copy()
        turned[held] = 1 - turned[held]
        other = probed.with_labels(turned)
        assert nested_scores(seen, probed)[fold] == pytest.approx(nested_scores(seen, other)[fold])
        assert cross_validated_scores(seen, probed)[held] == pytest.approx(
            1 - cross_validated_scores(seen, other)[held]
        )


@pytest.mark.slow
def test_the_best_of_probes_that_see_noise_is_as_good_as_guessing() -> None:
    draws, alarms, gained = 60, 0, []
    for seed in range(draws):
        probed, random = _questions(120, 2, 4, seed)
        rivals, _ = _rivals(probed, random)
        right, _ = rivals.best(probed)
        gained.append(float(right.mean()) - 0.5)
        alarms += gained[-1] > power.threshold(1) * power.deviation(right, np.full(120, 0.5), probed.groups)
    assert abs(np.mean(gained)) < 3 * np.std(gained) / np.sqrt(draws)
    assert np.std(gained) / np.sqrt(draws) < 0.01, "no more than 3 points could have been overlooked"
    assert stats.binomtest(alarms, draws, power.FALSE_ALARMS, alternative="greater").pvalue > 0.01


@pytest.mark.slow
def test_shortcut_of_the_reported_size_is_found_by_the_best_probe() -> None:
    draws, tests, chance = 40, 6, np.full(160, 0.25)
    probed, random = _questions(160, 4, 4)
    noise = [ProbeFeatures(random.normal(size=(640, 8)), "options", "forest") for _ in range(6)]
    looks = [lambda s=s: s for s in noise]
    rivals = CandidateProbes.of(looks, probed)
    spread = power.deviation(rivals.best(probed)[0], chance, probed.groups)
    probe = _probe(0.25, spread, rivals.learned(looks, probed, chance))
    size = power.smallest_detectable(probe, power.threshold(tests))
    assert 0.1 < size < 0.3
    found = 0
    for _ in range(draws):
        drawn, retold = _rivals(probed, random, size, 6)
        right, _ = drawn.best(retold)
        found += (right.mean() - 0.25) / power.deviation(right, chance, probed.groups) > power.threshold(tests)
    assert stats.binomtest(found, draws, 0.8, alternative="less").pvalue > 0.01, found


def _probe(chance: float, deviation: float, learned: tuple[float, ...] | None) -> Probe:
    return Probe("", "", "", 0, 0.0, chance, deviation, True, "", learned)


def test_undetectable_shortcuts_count_as_missed() -> None:
    beyond = power.threshold(20)

    def least(learned: tuple[float, ...] | None) -> float:
        return power.smallest_detectable(_probe(0.5, 0.1 / beyond, learned), beyond)

    assert least((0.01, 0.02, 0.03, 0.09)) == 1.0
    assert least((0.04, 0.08, 0.13, 0.25)) == pytest.approx(0.17)
    assert least((0.2, 0.25, 0.3, 0.4)) == pytest.approx(0.1), "no probe finds more than there is"
    assert least(None) > 0.1


@given(
    st.lists(
        st.tuples(
            st.sampled_from([0.25, 0.5]), st.floats(0.02, 0.09), st.none() | st.tuples(*[st.floats(-0.1, 0.3)] * 4)
        ),
        min_size=1,
        max_size=30,
    )
)
def test_the_alarms_are_shared_out_and_those_that_find_least_get_more(probes: list[Any]) -> None:
    made = [_probe(*probe) for probe in probes]
    beyond = power.thresholds(made)
    assert sum(stats.norm.sf(beyond)) <= power.FALSE_ALARMS + 1e-9
    even = power.threshold(len(made))
    worst = max(power.smallest_detectable(probe, even) for probe in made)
    halved = power.threshold(len(made), power.FALSE_ALARMS / 2)
    assert all(mine <= max(halved, even) + 1e-9 for mine in beyond)
    if worst == 1.0 and max(power.smallest_detectable(r, b) for r, b in zip(made, beyond, strict=True)) < 1.0:
        assert min(beyond) < even, "the one that found nothing was given some of the others' alarms"
