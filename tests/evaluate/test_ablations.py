"""Ablations: what is left out or changed is not in the request, and what a model then says counts as documented."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.evaluate.made import in_numbers, in_pictures, in_words
from tests.evaluate.test_evaluate import all_questions, evaluate, rows
from wmspec.eval.models import prompt, results
from wmspec.eval.models.ablation import Ablation, applies, reworded
from wmspec.eval.models.model import Reply
from wmspec.eval.models.question import Question
from wmspec.eval.models.request import Ask, Picture, Text
from wmspec.lang.check.tables.vocabulary import WORDS

#: Options that specs of the catalogue have.
OPTIONS = [
    ("yes", "no"), ("left", "right", "neither"), ("the left half", "the right half"), ("3", "4", "5", "6"),
    ("the red cube", "the blue cube", "neither"), ("red", "green", "oak"), ("10 cm", "20 cm", "30 cm"),
    ("less than its width", "more than its width"), ("to the left", "to the right", "away from you", "towards you"),
    ("in front of the plank", "behind the plank"), ("lighter", "heavier"), ("on the near side", "on the far side"),
]  # fmt: skip
NONE = "none of the others"


@pytest.fixture(scope="module")
def words(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return in_words(tmp_path_factory.mktemp("words"), 4)


@pytest.fixture(scope="module")
def pictures(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return in_pictures(tmp_path_factory.mktemp("pictures"), 2)


def ask(question: Question, ablation: Ablation, permutation: int = 0, name: str = "default") -> Ask:
    return Ask(question, prompt.load(name), permutation, ablation=ablation)


def with_options(question: Question, options: tuple[str, ...], answer: int = 0) -> Question:
    return replace(question, options=options, names=options, answer=answer, pictures=())


def said(request: Ask, text: str) -> results.Row:
    return results.row(request, Reply(text), "m", "default")


def text_of(request: Ask) -> str:
    return "\n".join(part.text for part in request.request.parts if isinstance(part, Text))


@pytest.mark.parametrize("name", ["default", "paper", "numbers", "montage"])
def test_without_the_truth_a_placeholder_appears(name: str, words: Path, pictures: Path) -> None:
    for question in [*all_questions(words), *all_questions(pictures)]:
        assert question.answer is not None
        for permutation in range(len(question.options)):
            request = ask(question, "truth", permutation, name)
            label = request.label(request.order.index(question.answer))
            assert f"{label}. {NONE}" in text_of(request).splitlines()
            if question.pictures and name != "montage":
                shown = [part.content for part in request.request.parts if isinstance(part, Picture)]
                assert question.pictures[question.answer] not in shown[len(question.context) :]
                assert len(shown) == len(question.context) + len(question.options) - 1
            assert said(request, label)["right"]
            assert said(request, NONE)["right"]
            other = request.label((request.order.index(question.answer) + 1) % len(question.options))
            assert not said(request, other)["right"]
            memorized = question.options[question.answer]
            if memorized is not None:
                assert said(request, f"The answer is {memorized}.")["status"] == "unparsed"


@pytest.mark.parametrize("options", OPTIONS)
def test_open_question_has_no_options(options: tuple[str, ...], words: Path) -> None:
    question = with_options(all_questions(words)[0], options)
    request = ask(question, "options")
    assert text_of(request).endswith(f"{question.text}\nAnswer in a few words.")
    for place, option in enumerate(options):
        row = said(request, option)
        assert (row["parsed"], row["right"], row["status"]) == (place, place == 0, "answered")
    for text in ("A", "(A)", "The first option", "Option A.", "something else"):
        assert said(request, text)["status"] == "unparsed", text


@pytest.mark.parametrize("options", OPTIONS)
def test_other_words_replace_all_options_and_labels_mean_the_same(options: tuple[str, ...], words: Path) -> None:
    for answer in range(len(options)):
        question = with_options(all_questions(words)[0], options, answer)
        assert applies(question, "wording")
        for permutation in range(len(options)):
            request, plain = ask(question, "wording", permutation), Ask(question, prompt.load("default"), permutation)
            lines = {line.partition(". ")[2] for line in text_of(request).splitlines()}
            assert not lines & {*options}
            assert lines >= {reworded(option) for option in options}
            for place in range(len(options)):
                label = request.label(place)
                assert said(request, label)["right"] == said(plain, label)["right"]
            assert said(request, reworded(options[answer]))["right"]


@given(st.sampled_from([*WORDS["color"], *WORDS["material"]]), st.sampled_from(["cube", "ball", "one", "tall box"]))
def test_a_look_follows_its_object(look: str, noun: str) -> None:
    assert reworded(f"the {look} {noun}") == f"the {noun} that is {look}"


@given(st.decimals(-1000, 1000, places=2).map(float), st.sampled_from([("cm", 100), ("g", 1000), ("cm/s", 100)]))
def test_a_value_in_another_unit_is_the_same(value: float, unit: tuple[str, int]) -> None:
    number, sign = reworded(f"{value:g} {unit[0]}").split()
    assert sign == {"cm": "m", "g": "kg", "cm/s": "m/s"}[unit[0]]
    assert float(number) * unit[1] == pytest.approx(float(f"{value:g}"))


@given(st.lists(st.sampled_from(sorted({o for options in OPTIONS for o in options})), min_size=2, unique=True))
def test_different_options_have_different_words(options: list[str]) -> None:
    assert len({reworded(option) for option in options}) == len(options)


def test_questions_without_other_wording_are_left_out(words: Path, pictures: Path, tmp_path: Path) -> None:
    numbers = in_numbers(tmp_path / "n", 2)
    for dataset in (words, pictures, numbers):
        question = all_questions(dataset)[0]
        assert applies(question, "truth") == bool(question.options)
        assert applies(question, "options") == (bool(question.options) and question.in_words)
        assert applies(question, "pictures")
    assert not applies(with_options(all_questions(words)[0], ("red", "a puzzling one")), "wording")
    args = ("-m", "openai:first", "--base-url", "http://127.0.0.1:9", "-o", tmp_path / "r.parquet")
    for ablation in ("options", "wording"):
        assert "no question has options in words" in evaluate(pictures, *args, "--ablate", ablation, code=2).output
    assert "no question has options" in evaluate(numbers, *args, "--ablate", "truth", code=2).output


def test_results_are_scored_again_with_the_words_that_were_shown(words: Path, tmp_path: Path) -> None:
    pytest.importorskip("openai")
    from tests.evaluate.manners import first_words, server

    out = tmp_path / "r.parquet"
    with server(first_words) as running:
        evaluate(words, "-m", "openai:right", "--base-url", running.address, "-o", out, "--ablate", "truth")
    before = rows(out)
    assert all(row["options"].count(NONE) == 1 and row["options"][row["answer"]] == NONE for row in before)
    evaluate("--rescore", out)
    assert rows(out) == before
