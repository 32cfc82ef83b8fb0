"""What came of a study: rows like a model's, α as Krippendorff has it, and a majority that a report counts alike."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Hashable
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from statsmodels.stats import inter_rater

from tests.command import wmspec
from tests.evaluate.made import in_numbers
from tests.study.visitor import letter
from wmspec.core.diagnostics import WmsError
from wmspec.dataset.build.reader import DatasetReader
from wmspec.eval.models import results
from wmspec.eval.models.agreement import alpha, majority
from wmspec.eval.report import replies
from wmspec.eval.study import store
from wmspec.eval.study.answers import Answer, Person
from wmspec.eval.study.collect import collect
from wmspec.eval.study.make import StudyOptions, make
from wmspec.eval.study.model import Study, load
from wmspec.eval.study.store import AnswerStore


def visit(folder: Path, name: str, off: int = 0, until: int = 10_000, checks: bool = True) -> None:
    """Somebody answers the first `until` steps, `off` places from the truth, and passes `checks` of attention ."""
    study, opened = load(folder), AnswerStore(folder / store.ANSWERS_FILE, load(folder))
    session = f"{int.from_bytes(name.encode()):032x}"
    slot = opened.begin(Person(session=session, rater=name)).slot
    for step in range(min(until, len(study.slots[slot]))):
        shown = study.step(slot, step)
        wrong = off if shown and shown[0].kind == "question" else int(not checks)
        opened.keep(session, Answer(step=step, text=letter(study, slot, step, wrong), seconds=2.0 + step % 3))
    opened.close()


# ---------------------------------------------------------------- α and majority


@given(
    st.integers(2, 6).flatmap(
        lambda raters: st.lists(st.lists(st.integers(0, 3), min_size=raters, max_size=raters), min_size=2, max_size=12)
    )
)
def test_alpha_is_the_kappa_of_statsmodels_but_for_small_samples(choices: list[list[int]]) -> None:
    """With as many raters of each item, 1 - α is 1 - κ times (n - 1) / n for n choices."""
    ours = alpha({"": choices})
    if len({c for of_one in choices for c in of_one}) == 1:
        assert ours is None
        return
    table, _ = inter_rater.aggregate_raters(np.array(choices))
    kappa, n = float(inter_rater.fleiss_kappa(table, method="fleiss")), sum(map(len, choices))
    assert ours == pytest.approx(1 - (1 - kappa) * (n - 1) / n)


def test_alpha_of_the_example_that_krippendorff_gives_and_of_nothing() -> None:
    raters = ("123321412...", "1233224125.3", ".3332342251.", "12332441251.")
    items = [[int(r[i]) for r in raters if r[i] != "."] for i in range(12)]
    assert alpha({"": items}) == pytest.approx(0.743, abs=5e-4)
    assert alpha({"": [[1], []]}) is None
    assert alpha({"": [[1, 2], [2]]}) == alpha({"": [[1, 2]]}), "one choice says nothing"
    assert alpha({"a": [[0, 0], [1, 1]], "b": [[2, 2], [5, 5]]}) == 1


@pytest.mark.parametrize("seed", range(3))
def test_random_raters_do_not_agree_in_any_task_nor_overall(seed: int) -> None:
    """30 raters who guess, where tasks have questions with 2, 3 and 4 options: 0 within 0.03 everywhere."""
    random = np.random.default_rng(seed)
    tasks: dict[str, dict[Hashable, list[list[int]]]] = {
        task: {
            (task, options): [list(map(int, random.integers(0, options, 30))) for _ in range(60)] for options in formats
        }
        for task, formats in {"a": (2,), "b": (4,), "c": (2, 3, 4), "d": (2, 4)}.items()
    }
    for formats in tasks.values():
        assert alpha(formats) == pytest.approx(0, abs=0.03)
    everything = {key: items for formats in tasks.values() for key, items in formats.items()}
    assert alpha(everything) == pytest.approx(0, abs=0.03)
    pooled = [items for formats in everything.values() for items in formats]
    assert (alpha({"": pooled}) or 0) > 0.05, "one set of categories for all finds agreement where there is none"


@given(st.lists(st.integers(0, 3), min_size=1, max_size=7), st.text("ab/", max_size=5), st.randoms())
def test_the_majority_has_most_votes_and_draws_by_the_question(votes: list[int], id: str, random: object) -> None:
    chosen, counts = majority(id, votes), Counter(votes)
    assert counts[chosen] == max(counts.values())
    assert chosen == majority(id, votes[::-1])


def test_ties_are_drawn_evenly() -> None:
    drawn = Counter(majority(f"task/{i}", [0, 1, 2]) for i in range(3000))
    assert all(900 < drawn[place] < 1100 for place in range(3))


# ---------------------------------------------------------------- results


def test_answers_are_results_like_a_models(dataset: DatasetReader, study: Path, tmp_path: Path) -> None:
    for name, off in (("anne", 0), ("ben", 0), ("carl", 1)):
        visit(study, name, off)
    made = collect(study, (), tmp_path / "r.parquet")
    rows, about = results.read(tmp_path / "r.parquet")
    assert (made.replies, made.missing) == (36, 0)
    assert len(rows) == 36
    by_name = {rater.rater: rater for rater in made.raters}
    assert (by_name["anne"].right, by_name["carl"].right, by_name["anne"].questions) == (12, 0, 12)
    assert {row["model"] for row in rows} == {"human:anne", "human:ben", "human:carl"}
    truth = {row["id"]: row["answer"] for task in dataset.tasks for row in dataset.rows(task, ["id", "answer"])}
    for row in rows:
        assert row["answer"] == truth[row["id"]]
        assert row["status"] == "answered"
        assert row["right"] == (row["model"] != "human:carl") == (row["parsed"] == row["answer"])
    assert about["asked"]["study"] == load(study).fingerprint
    assert results.rescore(tmp_path / "r.parquet")[1] == 0, "they are scored from their texts as all results are"


def test_a_report_has_the_same_majority(study: Path, tmp_path: Path) -> None:
    for name, off in (("anne", 0), ("ben", 1), ("carl", 2)):
        visit(study, name, off)
    made = collect(study, (), tmp_path / "r.parquet")
    people = replies.read([tmp_path / "r.parquet"], None)
    assert people.systems == ("people",)
    assert len(people.table) == 12
    of_all = next(agreed for agreed in made.agreement if not agreed.task)
    assert people.table["right"].mean() == pytest.approx(of_all.majority)
    assert 0 < of_all.majority < 1


def test_partial_sessions_count_and_inattentive_ones_are_excluded(study: Path, tmp_path: Path) -> None:
    visit(study, "anne")
    visit(study, "ben", until=6)
    visit(study, "carl", checks=False)
    made = collect(study, (), tmp_path / "r.parquet", least_checks=0.5)
    raters = {rater.rater: rater for rater in made.raters}
    assert raters["ben"].answered == 6 < raters["ben"].steps
    assert [raters[name].counted for name in ("anne", "carl")] == [True, False]
    assert raters["carl"].checks_passed == 0 < raters["carl"].checks
    assert made.replies == raters["anne"].questions + raters["ben"].questions
    assert made.missing == 36 - made.replies


def test_files_of_the_page_are_taken_too_and_once(study: Path, tmp_path: Path) -> None:
    made = load(study)
    one = answers_file(made, 1, "dora")
    paths = [tmp_path / "one.json", tmp_path / "again.json"]
    for path in paths:
        path.write_text(json.dumps(one))
    visit(study, "anne")
    said = wmspec("study", "collect", study, *paths, "-o", tmp_path / "r.parquet", folder=tmp_path).stdout
    assert "dora" in said
    assert "24 replies; 12 replies are missing" in said
    reported = json.loads(
        wmspec("study", "collect", study, *paths, "-o", "s.parquet", "--json", folder=tmp_path).stdout
    )
    assert [rater["rater"] for rater in reported["raters"]] == ["anne", "dora"] or len(reported["raters"]) == 2


def answers_file(study: Study, slot: int, rater: str = "") -> dict[str, object]:
    answers = [
        {"step": i, "text": letter(study, slot, i), "seconds": 3, "away": 0} for i in range(len(study.slots[slot]))
    ]
    return {
        "study": study.fingerprint,
        "session": "d" * 32,
        "rater": rater,
        "slot": slot,
        "code": "C",
        "answers": answers,
    }


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"study": "other"}, "another study"),
        ({"slot": 77}, "not one of its options"),
        ({"rater": "<b>"}, "not a file of answers (rater)"),
        ({"answers": [{"step": 0, "text": "Z", "seconds": 1}]}, "not one of its options"),
        ({"answers": [{"step": 0, "text": "A", "seconds": -1}]}, "answers.0.seconds"),
        ({"more": 1}, "not a file of answers (more)"),
    ],
)
def test_a_file_that_was_tampered_with_is_refused(
    change: dict[str, object], said: str, study: Path, tmp_path: Path
) -> None:
    (tmp_path / "a.json").write_text(json.dumps(answers_file(load(study), 0) | change))
    with pytest.raises(WmsError) as error:
        collect(study, [tmp_path / "a.json"], tmp_path / "r.parquet")
    assert said in str(error.value)
    assert not (tmp_path / "r.parquet").exists()


def test_two_of_a_name_are_two_people(study: Path, tmp_path: Path) -> None:
    for session in ("d", "e"):
        value = answers_file(load(study), 0, "anne") | {"session": session * 32}
        (tmp_path / f"{session}.json").write_text(json.dumps(value))
    made = collect(study, [tmp_path / "d.json", tmp_path / "e.json"], tmp_path / "r.parquet")
    assert [rater.rater for rater in made.raters] == ["anne-dddddddd", "anne-eeeeeeee"]


def test_numbers_are_scored_in_the_requested_unit(tmp_path: Path) -> None:
    study = make(
        DatasetReader.open(in_numbers(tmp_path / "data")), StudyOptions(per_task=4, raters=1), tmp_path / "study"
    )
    answers = []
    for step in range(len(study.slots[0])):
        shown = study.step(0, step)
        assert shown is not None
        item, _permutation = shown
        text = letter(study, 0, step) if item.options else f"{(item.number or 0) * 100 + 1 + step % 2 * 5:.1f}"
        answers.append({"step": step, "text": text, "seconds": 1})
    value = {"study": study.fingerprint, "session": "d" * 32, "rater": "", "slot": 0, "answers": answers}
    (tmp_path / "a.json").write_text(json.dumps(value))
    collect(tmp_path / "study", [tmp_path / "a.json"], tmp_path / "r.parquet")
    rows, _ = results.read(tmp_path / "r.parquet")
    assert sorted(row["right"] for row in rows) == [False, False, True, True]
    for row in rows:
        assert row["right"] == (abs(row["number"] - row["answer_number"]) < 0.02)


def test_nothing_is_overwritten_that_is_no_results(study: Path, tmp_path: Path) -> None:
    visit(study, "anne")
    (tmp_path / "r.parquet").write_text("my thesis")
    with pytest.raises(WmsError, match="holds no results"):
        collect(study, (), tmp_path / "r.parquet")
    assert (tmp_path / "r.parquet").read_text() == "my thesis"


def test_no_answers_yet(study: Path, tmp_path: Path) -> None:
    assert "no answers yet" in wmspec("study", "collect", study, "-o", "r.parquet", folder=tmp_path, code=2).stderr
    assert "holds no study" in wmspec("study", "serve", tmp_path, folder=tmp_path, code=2).stderr
