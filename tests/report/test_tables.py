"""The tables of perception and prediction, and their averages."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from tests.report.conftest import Made
from tests.report.made import Rater, answers
from wmspec.eval.report.replies import replies
from wmspec.eval.report.report import Report, accounts
from wmspec.eval.report.tables import Line, average, tables

DATA = Path(__file__).parent / "data"


def line(report: Report, kind: str, system: str) -> Line:
    (table,) = (t for t in report.tables if t.kind == kind)
    return next(found for found in (*table.lines, table.chance) if found.system == system)


@pytest.mark.parametrize(("table", "printed"), [("perception", 67.7), ("prediction", 47.5)])
def test_the_papers_entries_give_the_papers_averages(table: str, printed: float) -> None:
    with (DATA / f"wm_abench_{table}.csv").open(newline="") as file:
        entries = {r["column"]: float(r["value"]) for r in csv.DictReader(file) if r["model"] == "Qwen2-VL-72b"}
    mine = average(entries, {column: column.split("/")[0] for column in entries})
    assert mine == pytest.approx(printed, abs=0.06)
    assert np.mean(list(entries.values())) != pytest.approx(printed, abs=0.3), "a plain mean would do as well"


def test_a_column_without_a_value_is_left_out_of_the_average() -> None:
    values = {"a": 0.4, "b": 0.6, "c": 0.9, "d": float("nan"), "e": float("nan")}
    assert average(values, {"a": "x", "b": "x", "c": "y", "d": "y", "e": "z"}) == pytest.approx(0.7)


def test_accuracies_are_what_was_answered_and_chance_is_one_in_so_many(made: Made) -> None:
    one = line(made.report, "perception", "ideal")
    of_race = made.replies.table.query("system == 'ideal' and task == 'race'")
    assert one.tasks["race"].value == pytest.approx(of_race["right"].mean())
    assert one.average.value == pytest.approx((one.tasks["race"].value + one.tasks["tally"].value) / 2)
    assert one.average.low is not None
    assert one.average.low < 0.8 < (one.average.high or 0)
    assert line(made.report, "perception", "chance").tasks["race"].value == pytest.approx(0.5)
    assert line(made.report, "perception", "chance").average.value == pytest.approx(0.375)


def test_random_models_average_the_printed_chance(made: Made) -> None:
    """The 95 % intervals of 20 random models contain it, but for at most three (p 0.016 by chance)."""
    guessers = [Rater(f"guesser {n}", lambda row: 1 / len(row["option_kind"])) for n in range(20)]
    few = [row for row in made.rows if row["block"] % 2 == 0]
    for table in tables(replies(answers(few, *guessers))):
        chance = table.chance.average.value
        averages = [found.average for found in table.lines]
        assert len(averages) == 20
        values = [each.value for each in averages]
        assert abs(np.mean(values) - chance) < 3 * np.std(values) / np.sqrt(20)
        assert sum(not (each.low or 0) <= chance <= (each.high or 0) for each in averages) <= 3


def test_questions_about_what_is_seen_are_no_predictions(made: Made) -> None:
    """`moves` and `color` are asked in `roll` too: `foresees` knows them better than what comes."""
    probed = made.replies.table.query("system == 'foresees' and task == 'roll' and question_name == ''")
    assert line(made.report, "prediction", "foresees").tasks["roll"].value == pytest.approx(probed["right"].mean())


def test_replies_without_an_answer_are_wrong_and_have_outcomes_of_their_own(made: Made) -> None:
    one = line(made.report, "perception", "mumbles")
    assert one.parsed == pytest.approx(0.6, abs=0.04)
    assert one.average.value == pytest.approx(0.75 * one.parsed, abs=0.02)
    account = next(a for a in made.report.accounts if a.system == "mumbles")
    assert account.unparsed == sum(row["index"] % 4 == 0 for row in made.rows)


def test_requests_that_failed_are_wrong_and_counted(made: Made) -> None:
    broken = Rater("broken", lambda row: 1.0, status=lambda row: "error" if row["index"] % 2 else "answered")
    read = replies(answers(made.rows, broken))
    (account,) = accounts(read)
    assert account.error == sum(row["index"] % 2 for row in made.rows)
    assert account.answered + account.error == account.replies
    (cause,) = account.causes
    assert (cause.outcome, cause.cause, cause.count) == ("error", "broken", account.error)
    found = line_of(read, "broken")
    assert found.average.value < 0.6
    assert found.parsed == 1.0


def line_of(read: object, system: str) -> Line:
    return next(found for table in tables(read) for found in table.lines if found.system == system)  # type: ignore[arg-type]


def test_people_are_the_majority_of_the_raters(made: Made) -> None:
    whole = line(made.report, "prediction", "people").tasks["roll"]
    p = 0.9
    most = p**3 + 3 * p**2 * (1 - p)  # two or three of three; a tie of three wrong ones or of one right is drawn
    tied = 3 * p * (1 - p) ** 2 * (2 / 3) / 3  # one right, two that are wrong in different ways
    assert whole.questions == sum(
        r["task"] == "roll" and not r["question_name"] and r["index"] % 3 == 0 for r in made.rows
    )
    assert whole.value == pytest.approx(most + tied, abs=0.05)
    assert made.report.raters == 3


def test_ablations_are_systems_of_their_own(made: Made) -> None:
    seen = answers(made.rows[:40], Rater("model", lambda row: 1.0))
    blind = answers(made.rows[:40], Rater("model", lambda row: 0.0)).assign(ablation="pictures")
    read = replies(pd.concat([seen, blind], ignore_index=True))
    assert read.systems == ("model", "model · pictures")
    assert read.scores["model"].eq(1).all()
    assert read.scores["model · pictures"].eq(0).all()
