"""Who is shown what: balanced, the same for the same seed, and nothing given away."""

from __future__ import annotations

import itertools
import json
import sqlite3
from collections import Counter
from contextlib import closing
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.evaluate.made import in_numbers
from wmspec.core.diagnostics import WmsError
from wmspec.dataset.build.reader import DatasetReader
from wmspec.eval.study import store
from wmspec.eval.study.answers import Person
from wmspec.eval.study.make import StudyOptions, make, slots
from wmspec.eval.study.model import Item, load


def items(sizes: list[int], options: int, checks: int = 0, practice: int = 0) -> list[Item]:
    words = tuple("abcdefgh"[:options])
    made = [
        Item(id=f"t{t}/{i}", kind=kind, task=f"t{t}", text="?", words=words, answer=i * 5 % options)  # type: ignore[arg-type]
        for t, size in enumerate(sizes)
        for kind, count in (("practice", practice), ("question", size))
        for i in range(count)
    ]
    return made + [Item(id=f"c{i}", kind="check", task="", text="?", words=words, answer=0) for i in range(checks)]


@given(
    sizes=st.lists(st.integers(1, 12), min_size=1, max_size=4),
    options=st.integers(2, 5),
    raters=st.integers(1, 5),
    most=st.integers(1, 30),
    seed=st.integers(0, 5),
)
def test_every_question_has_its_raters_and_everybody_a_fair_share(
    sizes: list[int], options: int, raters: int, most: int, seed: int
) -> None:
    given_ = items(sizes, options)
    dealt = slots(given_, raters, most, 0, seed)
    seen = Counter(step.item for slot in dealt for step in slot)
    assert set(seen.values()) == {raters}
    assert len(seen) == len(given_)
    lengths = {len(slot) for slot in dealt}
    assert max(lengths) <= most
    assert max(lengths) - min(lengths) <= 1
    assert all(len({step.item for step in slot}) == len(slot) for slot in dealt), "nobody is asked twice"
    for slot in dealt:
        tasks = [given_[step.item].task for step in slot]
        assert len([1 for a, b in itertools.pairwise(tasks) if a != b]) == len(set(tasks)) - 1
    assert dealt == slots(given_, raters, most, 0, seed)


@given(size=st.integers(1, 40), options=st.integers(2, 5), raters=st.integers(1, 6))
def test_the_truth_is_at_every_place_equally_often(size: int, options: int, raters: int) -> None:
    given_ = items([size], options)
    for slot in slots(given_, raters, 10_000, 0, 0):
        places = Counter(given_[s.item].order(s.permutation).index(given_[s.item].answer or 0) for s in slot)
        counts = [places[place] for place in range(options)]
        assert max(counts) - min(counts) <= 1
    every = [(s.item, s.permutation) for slot in slots(given_, raters, 10_000, 0, 0) for s in slot]
    assert len(set(every)) == size * min(raters, options), "raters of a question see other orders"


def test_practice_comes_first_and_checks_in_between() -> None:
    given_ = items([30, 30], 4, checks=6, practice=2)
    for slot in slots(given_, 3, 60, 10, 1):
        kinds = [given_[step.item].kind for step in slot]
        assert Counter(kinds) == {"question": 60, "practice": 4, "check": 6}
        assert kinds[:2] == ["practice", "practice"]
        first: dict[tuple[str, str], int] = {}
        for place, step in enumerate(slot):
            item = given_[step.item]
            if item.task:
                first.setdefault((item.task, item.kind), place)
        assert all(first[task, "practice"] < first[task, "question"] for task in ("t0", "t1"))


# ---------------------------------------------------------------- made of a dataset


def test_the_same_again_and_other_for_another_seed(dataset: DatasetReader, tmp_path: Path) -> None:
    one = make(dataset, StudyOptions(per_task=5), tmp_path / "a")
    assert one == make(dataset, StudyOptions(per_task=5), tmp_path / "b") == load(tmp_path / "b")
    assert (tmp_path / "a/page/index.html").read_bytes() == (tmp_path / "b/page/index.html").read_bytes()
    assert one != make(dataset, StudyOptions(per_task=5, seed=1), tmp_path / "c")


def test_questions_are_of_different_instances_and_engines_take_turns(dataset: DatasetReader, tmp_path: Path) -> None:
    study = make(dataset, StudyOptions(per_task=6), tmp_path)
    questions = [item for item in study.items if item.kind != "check"]
    assert len({(i.task, i.index) for i in questions}) == len(questions) == 14
    assert len(Counter(i.engine for i in questions if i.task == "collide")) == 3


def test_page_has_no_truth_except_in_practice(study: Path) -> None:
    text = (study / "page/index.html").read_text()
    data = json.loads(text.split('id="data">')[1].split("</script>")[0])
    made = load(study)
    for shown, item in zip(data["items"], made.items, strict=True):
        assert ("answer" in shown) == (item.kind == "practice")
    assert not any(item.id in text for item in made.items)
    assert {p.name for p in (study / "page").iterdir()} == {"index.html", "pictures"}


def test_texts_that_were_replaced_stay_and_end_nothing(dataset: DatasetReader, study: Path) -> None:
    (study / "texts/consent.txt").write_text("</script><script>alert(1)</script>")
    make(dataset, StudyOptions(per_task=6, raters=3, check_every=6), study)
    page = (study / "page/index.html").read_text()
    assert page.count("</script>") == 2
    assert "alert(1)" in page


def test_another_study_never_takes_the_place_of_one_with_answers(dataset: DatasetReader, study: Path) -> None:
    store.AnswerStore(study / store.ANSWERS_FILE, load(study)).close()
    with pytest.raises(WmsError, match="answers to another study"):
        make(dataset, StudyOptions(per_task=3), study)
    make(dataset, StudyOptions(per_task=6, raters=3, check_every=6), study)


def test_answers_of_an_earlier_version_are_kept(study: Path) -> None:
    """Its visits had no ids of the site that invites people."""
    place = study / store.ANSWERS_FILE
    answers = store.AnswerStore(place, load(study))
    answers.begin(Person(session="a" * 32, rater="anne"))
    answers.close()
    with closing(sqlite3.connect(place)) as file, file:
        for column in ("study_id", "session_id"):
            file.execute(f"alter table visit drop column {column}")
    (visit,) = store.AnswerStore(place, load(study)).visits()
    assert (visit.rater, visit.study_id, visit.session_id) == ("anne", "", "")


def test_missing_parts_of_a_dataset_are_reported(dataset: DatasetReader, tmp_path: Path) -> None:
    with pytest.raises(WmsError, match="no task `colide`"):
        make(dataset, StudyOptions(tasks=("colide",)), tmp_path)
    with pytest.raises(WmsError, match="no engine `bullet`"):
        make(dataset, StudyOptions(engines=("bullet",)), tmp_path)


def test_numbers_are_requested_in_readable_units(tmp_path: Path) -> None:
    dataset = DatasetReader.open(in_numbers(tmp_path / "data"))
    study = make(dataset, StudyOptions(per_task=4), tmp_path / "study")
    assert {item.shown_unit for item in study.items if item.kind == "question"} == {"cm"}
    practice = next(item for item in study.public()["items"] if item["kind"] == "practice")
    item = next(item for item in study.items if item.kind == "practice")
    assert practice["truth"][0] == pytest.approx(100 * (item.number or 0))
    assert practice["truth"][1] == pytest.approx(2)
