"""A dataset, raters with known weaknesses, and the report on them."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from scipy.special import expit

pytest.importorskip("statsmodels")
pytest.importorskip("matplotlib")

from tests.report.made import Knows, Rater, answers, dataset, rows, write
from tests.shared import Shared
from wmspec.dataset.build.rows import Row
from wmspec.eval.report.questions import Questions
from wmspec.eval.report.replies import Replies, replies
from wmspec.eval.report.report import Report, analyse

#: What `seer` can tell apart: speeds in this ratio, half-way from guessing to its best.
THRESHOLD, STEEP, LAPSE = 1.5, 4.0, 0.02


def seer(threshold: float = THRESHOLD, otherwise: float = 0.7) -> Knows:
    """How probably one with a threshold is right: as its curve says in `race`, elsewhere `otherwise`."""

    def knows(row: Row) -> float:
        if row["task"] != "race":
            return otherwise
        x = abs(np.log2(row["difference"]["value"]))
        return float(0.5 + (0.5 - LAPSE) * expit(STEEP * (x - np.log2(threshold))))

    return knows


def entangled(row: Row) -> float:
    """Right half as often where things are red."""
    return 0.8 * (0.5 if row["factor.color"] == "red" else 1.0)


def foresees(row: Row) -> float:
    """Predicts well where it tells colours (all but green), and guesses where it does not."""
    if row["task"] != "roll":
        return 0.7
    reported = row["factor.color"] != "green"
    if row["question_name"]:
        return 1.0 if reported or row["question_name"] == "moves" else 0.0
    return 0.85 if reported else 0.25


RATERS = (
    Rater("seer", seer()),
    Rater("ideal", lambda row: 0.8),
    Rater("entangled", entangled),
    Rater("foresees", foresees),
    Rater("first", lambda row: 0.4, place=0, permutations=2),
    Rater("sure", lambda row: 1.0, permutations=2),
    Rater("mumbles", lambda row: 0.6, status=lambda row: "unparsed" if row["index"] % 4 == 0 else "answered"),
    Rater("confused", lambda row: 0.4, wrongly=lambda row: [0.01 + ("action" in str(c)) for c in row["option_change"]]),
    Rater("random", lambda row: 1 / len(row["option_kind"])),
)  # fmt: skip
PEOPLE = tuple(Rater(f"human:{name}", seer(1.2, 0.9)) for name in "abc")


@dataclass(frozen=True)
class Made:
    """Where the dataset and the results are, what is read from them, and the report."""

    folder: Path
    results: Path
    rows: list[Row]
    replies: Replies
    report: Report


@pytest.fixture(scope="session")
def made(shared: Shared) -> Made:
    def make() -> Made:
        folder = shared.folder("report/dataset", dataset)
        questions = rows(folder)
        few = [row for row in questions if row["index"] % 3 == 0]
        table = pd.concat([answers(questions, *RATERS), answers(few, *PEOPLE)], ignore_index=True)
        results = shared.folder("report/results", lambda place: write(place / "all.parquet", table)) / "all.parquet"
        read = replies(table, Questions.read(folder))
        return Made(folder, results, questions, read, analyse(read, "made", lambda name, count: None))

    return shared.value("report/made", make)
