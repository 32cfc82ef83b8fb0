"""A known factor leaves the options with its level, and no rule of thumb chooses among them."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from tests.audit.made import make, slide
from wmspec.dataset.audit import combined, probes
from wmspec.dataset.audit.cases import Unit, units
from wmspec.dataset.audit.given import closed_set, given_in_words, varied_factors
from wmspec.dataset.audit.model import Probe
from wmspec.dataset.build.reader import DatasetReader

SEEDS = [0, *(pytest.param(seed, marks=pytest.mark.slow) for seed in (7, 11))]


def unit(folder: Path) -> Unit:
    (made,) = units(DatasetReader.open(folder), "slide", 2000)
    return made


def probed(made: Unit) -> dict[str, Probe]:
    """The probes of known factors, by what they see, with their intervals."""
    groups = [str(case.row["block"]) for case in made.sampled]
    found = probes.with_intervals(combined.probes(made, made.sampled, groups, moments=2))
    return {probe.sees: probe for probe in found}


def verdicts(found: dict[str, Probe]) -> dict[str, str]:
    return {sees: probes.verdict(probe) for sees, probe in found.items() if probe.judged}


def test_the_closed_set_is_read_from_the_row(tmp_path: Path) -> None:
    made = unit(make(tmp_path / "made", "slide", slide(), 40))
    assert varied_factors(made.sampled) == {"way": "action", "weight": "state"}
    for case in made.sampled:
        read = closed_set(case)
        assert read is not None
        assert sorted(zip(read.levels["weight"], read.levels["way"], strict=True)) == [
            (weight, way) for weight in ("heavy", "light") for way in ("left", "right")
        ]
        for known in ("weight", "way"):
            assert read.levels[known][case.row["answer"]] == case.row[f"level.{known}"]
            assert sum(read.left(known, case.row["answer"])) == 2
    assert given_in_words(made, "weight")
    assert not given_in_words(made, "way")


@pytest.mark.parametrize("seed", SEEDS)
def test_nothing_is_found_where_nothing_is_planted(seed: int, tmp_path: Path) -> None:
    found = verdicts(probed(unit(make(tmp_path / "made", "slide", slide(), 120, seed=seed))))
    assert set(found.values()) == {"holds"}
    assert {"`weight`", "`way`"} < found.keys()
    assert sum(sees.endswith("(the best rule)") for sees in found) == 2


@pytest.mark.usefixtures("roughly")
@pytest.mark.parametrize("seed", SEEDS)
def test_the_nearest_option_with_the_weight_in_words_is_found(seed: int, tmp_path: Path) -> None:
    """The nearest option alone is true in half of the questions: where the ball is heavy."""
    found = probed(unit(make(tmp_path / "made", "slide", slide(revealing=True), 80, seed=seed)))
    assert found["`weight`"].accuracy == pytest.approx(0.5, abs=0.1)
    assert found["`weight` and likeness to the last picture"].accuracy > 0.9
    (failing,) = (sees for sees, verdict in verdicts(found).items() if verdict == "fails")
    assert failing.startswith("`weight` and ")


@pytest.mark.usefixtures("roughly")
def test_a_picture_may_show_a_state_that_is_not_in_words(tmp_path: Path) -> None:
    made = unit(make(tmp_path / "made", "slide", slide(in_words=False), 20))
    rules = [probe for sees, probe in probed(made).items() if sees.startswith("`way` and likeness")]
    assert {probe.why for probe in rules} == {"the pictures show what these options differ in"}
    assert not any(probe.judged for probe in rules)


@pytest.mark.usefixtures("roughly")
def test_revealing_state_is_found(tmp_path: Path) -> None:
    """Most light balls that go left, and most heavy ones that go right, were rejected."""
    made = unit(make(tmp_path / "made", "slide", slide(), 140))
    kept = tuple(
        case
        for case in made.cases
        if (case.row["level.weight"] == "light") == (case.row["level.way"] == "right") or case.row["block"] % 4 == 0
    )
    found = verdicts(probed(replace(made, cases=kept)))
    assert found["`weight`"] == "fails"
    assert found["`way`"] == "fails"
