"""Same/different questions: d′ of an ideal observer with known noise and bias is found, and bias does not change it."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.stats import norm

from wmspec.eval.report.detection import Detection, detections
from wmspec.eval.report.questions import Questions
from wmspec.eval.report.replies import replies

PAIRS, TIERS = 600, (1.0, 2.0)


def observed(
    sensitivity: tuple[float, float], criterion: float, seed: int, answers: tuple[str, str] = ("yes", "no")
) -> list[Detection]:
    """Return the results of an observer with equal-variance Gaussian noise: it says "no" above its criterion."""
    generator = np.random.default_rng(seed)
    rows, known = [], []
    for number in range(2 * PAIRS):
        tier = None if number % 2 else TIERS[number // 2 % 2]
        mean = 0.0 if tier is None else sensitivity[TIERS.index(tier)]
        middle = float(np.mean(sensitivity)) / 2
        says_different = generator.normal(mean) > criterion + middle
        name = f"t/{number}"
        right = bool(says_different == (tier is not None))
        rows.append({
            "id": name, "task": "t", "dimension": "perception.vision.color", "question_name": "pair", "engine": "e",
            "index": number, "group": f"t/{number // 4}", "model": "m", "prompt": "p", "ablation": "", "permutation": 0,
            "sample": 0, "order": [0, 1], "answer": 0, "parsed": 0, "right": right, "status": "answered", "cost": 0.0,
            "tokens_in": 0, "tokens_out": 0,
        })  # fmt: skip
        known.append({
            "id": name, "task": "t", "index": number, "question": 0, "question_name": "pair", "engine": "e", "text": "",
            "options": 2, "truth": answers[tier is not None], "query": False, "quantity": "step", "unit": "",
            "difference": tier or 0.0,
        })  # fmt: skip
    return list(detections(replies(pd.DataFrame(rows), Questions(pd.DataFrame(known).set_index("id"), {}, {}))))


@settings(max_examples=8, deadline=None)
@given(st.floats(0.5, 2.5), st.floats(-0.7, 0.7), st.integers(0, 99))
def test_it_finds_sensitivity_and_bias(sensitivity: float, criterion: float, seed: int) -> None:
    whole = observed((sensitivity, sensitivity), criterion, seed)[0]
    assert whole.difference is None
    assert whole.sensitivity.value == pytest.approx(sensitivity, abs=0.35)
    assert whole.criterion.value == pytest.approx(criterion, abs=0.2)
    assert whole.sensitivity.low is not None
    assert whole.sensitivity.high is not None
    assert whole.sensitivity.low < whole.sensitivity.value < whole.sensitivity.high


def test_tiers_have_their_own_sensitivity_and_the_same_false_alarms() -> None:
    _, hard, easy = observed((0.5, 2.5), 0.0, 5)
    assert (hard.difference, easy.difference) == TIERS
    assert hard.alarms.value == easy.alarms.value
    assert easy.sensitivity.value - hard.sensitivity.value == pytest.approx(2.0, abs=0.4)


def test_always_yes_has_no_sensitivity_and_a_large_criterion() -> None:
    whole = observed((2.0, 2.0), 99.0, 1)[0]
    assert whole.hits.value == whole.alarms.value == 0
    assert whole.sensitivity.value == pytest.approx(0.0, abs=1e-9)
    assert whole.criterion.value == pytest.approx(-norm.ppf(0.5 / (PAIRS + 1)))


def test_a_question_with_one_answer_for_all_differences_is_no_detection() -> None:
    assert observed((1.0, 1.0), 0.0, 2, answers=("yes", "yes")) == []
