"""Equating: scores on harder questions are brought to the scale of an earlier set, with intervals that hold."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from click.testing import CliRunner
from scipy.special import expit

from tests.report.conftest import Made
from tests.report.made import SCHEMA, Rater, answers
from wmspec.cli import main
from wmspec.core.diagnostics import WmsError
from wmspec.eval.report.equating import Equating, equate, expected, fit
from wmspec.eval.report.intervals import seeded_generator
from wmspec.eval.report.replies import Replies, replies

CHANCE = 0.25
TASKS = {"race": "prediction.mechanistic", "tally": "perception.quantity", "roll": "prediction.mechanistic"}


def drawn_set(abilities: dict[str, float], harder: float, key: object, groups: int = 60, members: int = 3) -> Replies:
    """A set of questions with random difficulties, in groups of one difficulty, answered by models of known ability."""
    random, rows = seeded_generator("equating test", key), []
    for task, dimension in TASKS.items():
        for group in range(groups):
            difficulty = random.normal(harder, 1.0)
            for member in range(members):
                for model, able in abilities.items():
                    right = random.random() < CHANCE + (1 - CHANCE) * expit(able - difficulty)
                    rows.append({
                        "id": f"{task}/{key}-{group}-{member}", "task": task, "dimension": dimension,
                        "question_name": "", "engine": "mujoco", "index": group * members + member, "block": group,
                        "group": f"{task}/{group}", "model": model, "model_version": model, "prompt": "default",
                        "prompt_hash": "p", "ablation": None, "permutation": 0, "sample": 0, "order": [0, 1, 2, 3],
                        "answer": 0, "text": "A", "parsed": 0 if right else 1, "number": None, "right": right,
                        "status": "answered", "error": None, "tokens_in": 1, "tokens_out": 1, "cost": None,
                        "seconds": 1.0,
                    })  # fmt: skip
    return replies(pd.DataFrame(rows))


def true_score(ability: float) -> float:
    points, weights = np.polynomial.hermite_e.hermegauss(61)
    return float(CHANCE + (1 - CHANCE) * (weights / weights.sum()) @ expit(ability - points))


LINKS = {"weak": -0.5, "middling": 0.6, "strong": 1.8}
NEW = {"newcomer": 1.2, "late": -1.0}


def equated(number: int, harder: float, links: dict[str, float] = LINKS) -> Equating:
    earlier = drawn_set(links, 0.0, f"earlier {number}")
    fresh = drawn_set(links | NEW, harder, f"fresh {number}")
    return equate(fresh, earlier)[0]


def test_scores_of_harder_questions_are_those_of_the_earlier_set() -> None:
    """Over several sets: no bias where raw scores have one, and 95 % intervals that contain the truth."""
    errors, raw, covered = [], [], []
    for number in range(4):
        found = equated(number, 0.8)
        assert found.kind == ""
        for score in found.scores:
            true = true_score((LINKS | NEW)[score.model])
            errors.append(score.equated.value - true)
            raw.append(score.fresh - true)
            assert score.equated.low is not None
            assert score.equated.high is not None
            covered.append(score.equated.low <= true <= score.equated.high)
    assert np.mean(raw) < -0.08, "the questions are harder"
    assert abs(np.mean(errors)) < 0.02
    assert np.sqrt(np.mean(np.square(errors))) < 0.045
    assert np.mean(covered) > 0.85


def test_the_shift_is_found_and_none_is_invented() -> None:
    harder, same = equated(1, 0.8).shift, equated(2, 0.0).shift
    assert harder.low is not None
    assert harder.low > 0.05
    assert same.low is not None
    assert same.high is not None
    assert same.low < 0.0 < same.high


def test_models_are_ordered_and_links_are_marked() -> None:
    found = equated(3, 0.5)
    assert [score.model for score in found.scores] == ["strong", "newcomer", "middling", "weak", "late"]
    assert {score.model for score in found.scores if score.earlier is not None} == set(LINKS)


def test_each_kind_of_task_has_its_own_scores() -> None:
    fresh, earlier = drawn_set(LINKS | NEW, 0.4, "f"), drawn_set(LINKS, 0.0, "e")
    assert [one.kind for one in equate(fresh, earlier)] == ["", "perception", "prediction"]


def test_one_link_is_too_few() -> None:
    with pytest.raises(WmsError, match="1 models answered both sets"):
        equated(4, 0.0, {"weak": -0.5})


def test_a_perfect_and_a_hopeless_model_have_finite_scores() -> None:
    found = equated(5, 0.0, LINKS | {"perfect": 50.0, "hopeless": -50.0})
    by_name = {score.model: score.equated.value for score in found.scores}
    assert by_name["perfect"] > 0.97
    assert by_name["hopeless"] == pytest.approx(CHANCE, abs=0.05)
    assert {score.model for score in found.scores if score.is_near_chance} == {"hopeless"}


def test_the_gradient_is_that_of_the_likelihood() -> None:
    from wmspec.eval.report.equating import _likelihood

    random = np.random.default_rng(0)
    y = random.integers(0, 2, (30, 4)).astype(float)
    y[:10, 3] = np.nan
    c, fresh = np.full(30, 0.25), np.repeat([0.0, 1.0], 15)
    q = random.normal(0, 0.5, 6)
    _, slopes = _likelihood(q, y, c, fresh)
    for place in range(6):
        step = np.zeros(6)
        step[place] = 1e-5
        numeric = (_likelihood(q + step, y, c, fresh)[0] - _likelihood(q - step, y, c, fresh)[0]) / 2e-5
        assert slopes.sum(0)[place] == pytest.approx(numeric, rel=1e-5, abs=1e-6)


def test_the_spread_of_difficulties_is_found() -> None:
    random = np.random.default_rng(1)
    able, hard = np.array([-1.0, 0.0, 1.0, 2.0]), np.r_[random.normal(0, 1.5, 1500), random.normal(0.7, 1.5, 1500)]
    y = (random.random((3000, 4)) < 0.25 + 0.75 * expit(able - hard[:, None])).astype(float)
    parameters, _, _ = fit(y, np.full(3000, 0.25), np.repeat([0.0, 1.0], 1500))
    assert parameters[:4] == pytest.approx(able, abs=0.35)
    assert parameters[4] == pytest.approx(0.7, abs=0.15)
    assert np.exp(parameters[5]) == pytest.approx(1.5, abs=0.4)
    assert expected(parameters[None], np.full(3000, 0.25), True)[0] == pytest.approx(y[1500:].mean(0), abs=0.035)


def test_the_command_prints_them(made: Made, tmp_path: Path) -> None:
    import pyarrow as pa
    import pyarrow.parquet as pq

    for name, salt, models in (("old", "1", ("a", "b")), ("new", "2", ("a", "b", "c"))):
        table = answers(made.rows[::3], *(Rater(f"{salt}{model}", lambda row: 0.7) for model in models))
        table["model"] = table["model"].str.removeprefix(salt)
        pq.write_table(pa.Table.from_pandas(table, schema=SCHEMA, preserve_index=False), tmp_path / f"{name}.parquet")
    args = ["report", str(tmp_path / "new.parquet"), "--equate", str(tmp_path / "old.parquet"), "--name", "c=The third"]
    done = CliRunner().invoke(main, args)
    assert done.exit_code == 0, done.output
    assert "the new questions are harder by" in done.output
    assert "The third: " in done.output
    assert "equated" in done.output
