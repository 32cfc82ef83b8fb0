"""Engines that agree, a majority of them, and one that rejects: what is kept and what is reported."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.dataset.made import pictures, question_row
from wmspec.runtime.questions.consensus import Consensus, agree, consensus, judge, picked_option
from wmspec.runtime.questions.kinds.labels import LabelAnswer
from wmspec.runtime.questions.kinds.numbers import NumberAnswer
from wmspec.runtime.questions.kinds.pictures import PictureAnswer
from wmspec.runtime.questions.model import Number, Option, QuestionRow, Rejected

ENGINES = ("mujoco", "pybullet", "sapien")


def label(engine: str, answer: int) -> QuestionRow:
    """A question whose options are in another order in every engine."""
    names = ["left", "right", "neither"]
    order = np.roll(np.arange(3), len(engine))
    options = tuple(Option("truth" if i == answer else "label", names[i], text=names[i]) for i in order)
    return replace(
        question_row("motion_speed", 1, engine),
        options=options,
        answer=[*map(int, order)].index(answer),
        value=names[answer],
        evidence=LabelAnswer(names[answer], tuple(names)),
        agreement=(),
    )


def picture(engine: str, *places: float, looks: tuple[str, ...] = (), slot: int = 0) -> QuestionRow:
    """A picture question: where the ball is in the truth, which stands at its slot, and in the counterfactuals."""
    evidence = pictures(*places, looks=looks)
    names = list(evidence.names[1:])
    names.insert(slot, evidence.names[0])
    options = tuple(Option("truth" if n == "truth" else "counterfactual", n) for n in names)
    return replace(question_row("collide", 1, engine), options=options, answer=slot, evidence=evidence, agreement=())


def number(engine: str, value: float) -> QuestionRow:
    return replace(
        question_row("motion_speed", 1, engine),
        options=(),
        answer=None,
        value=f"{value}",
        number=Number(value, "m", 0.02),
        evidence=NumberAnswer(value, 0.02),
        agreement=(),
    )


def test_the_answers_of_engines_are_in_words() -> None:
    mine = label("mujoco", 0)
    result = judge(mine, {"mujoco": mine, "pybullet": label("pybullet", 1), "sapien": lost("sapien")}, "all", {})
    assert isinstance(result, Rejected)
    words = "mujoco answers left; pybullet answers right; sapien rejects it: margin: 1.1 where 1.2 apart was required"
    assert result.detail == words
    mine = picture("mujoco", 0, 1, 2)
    result = judge(mine, {"mujoco": mine, "sapien": picture("sapien", 1, 0, 2)}, "all", {})
    assert isinstance(result, Rejected)
    assert result.detail == "mujoco picks picture 1; sapien picks picture 2"


def lost(engine: str) -> Rejected:
    return Rejected("motion_speed", 1, 0, engine, "margin", "1.1 where 1.2 apart was required")


def kept(expected: Consensus, *answers: QuestionRow | Rejected) -> str:
    """The first letters of the engines that keep the question."""
    found = consensus({a.engine: a for a in answers}, expected)
    assert list(found) == [a.engine for a in answers]
    return "".join(e[0] for e, a in found.items() if isinstance(a, QuestionRow))


@pytest.mark.parametrize(
    ("answers", "kept_of"),
    [
        ((0, 0, 0), ("mps", "mps", "mps")),
        ((0, 1, 0), ("", "ms", "mps")),
        ((0, 1, 2), ("", "", "mps")),
        ((None, 1, 1), ("", "ps", "ps")),
        ((None, 1, None), ("", "", "p")),
    ],
)
def test_labels(answers: tuple[int | None, ...], kept_of: tuple[str, str, str]) -> None:
    made = [label(e, a) if a is not None else lost(e) for e, a in zip(ENGINES, answers, strict=True)]
    assert tuple(kept(expected, *made) for expected in ("all", "majority", "none")) == kept_of


def test_pictures_agree_where_each_picks_the_others_truth() -> None:
    mine, near, far = (picture(e, x, 0.2, 0.4) for e, x in zip(ENGINES, (0.0, 0.05, 0.19), strict=True))
    assert agree(mine, near)
    assert not agree(mine, far)
    assert picked_option(mine, far) == 1
    assert kept("majority", mine, near, far) == "mp"
    assert kept("all", mine, near, far) == ""


@pytest.mark.parametrize("slot", [0, 1, 2])
def test_options_of_different_looks_are_distinguished_by_look(slot: int) -> None:
    """Wherever the truth stands: it was the first of the nearest once."""
    looks = ("red", "blue", "red")
    mine = picture("mujoco", 0.0, 0.0, 0.4, looks=looks, slot=slot)
    near = picture("pybullet", 0.01, 0.01, 0.41, looks=looks, slot=slot)
    blue = picture("sapien", 0.0, 0.0, 0.4, looks=("blue", "red", "red"), slot=slot)
    assert picked_option(mine, near) == slot
    assert agree(mine, near)
    assert mine.options[picked_option(mine, blue) or 0].name == "other_1"
    assert not agree(mine, blue)


@pytest.mark.parametrize("slot", [0, 1, 2])
def test_indistinguishable_option_is_not_picked(slot: int) -> None:
    mine, other = picture("mujoco", 0.0, 0.0, 0.4, slot=slot), picture("sapien", 0.01, 0.01, 0.4, slot=slot)
    assert picked_option(mine, other) is None
    assert not agree(mine, other)


def test_a_body_that_is_gone_is_far_from_one_that_is_there() -> None:
    mine, other = picture("mujoco", 0.0, 0.2, 0.4), picture("sapien", 0.21, 0.2, 0.4)
    assert picked_option(mine, other) == 1
    assert isinstance(other.evidence, PictureAnswer)
    gone = replace(other, evidence=replace(other.evidence, outcomes=np.full_like(other.evidence.outcomes, np.nan)))
    assert picked_option(mine, gone) is None, "no nearer to one than to another"


def test_open_numbers_agree_within_what_is_allowed() -> None:
    assert kept("all", number("mujoco", 1.0), number("sapien", 1.019)) == "ms"
    assert kept("all", number("mujoco", 1.0), number("sapien", 1.021)) == ""


def test_row_has_the_answer_of_every_engine() -> None:
    found = consensus({a.engine: a for a in (label("mujoco", 0), label("pybullet", 1), lost("sapien"))}, "none")
    mine = found["mujoco"]
    assert isinstance(mine, QuestionRow)
    votes = {v.engine: v for v in mine.agreement}
    assert mine.options[votes["mujoco"].answer or 0].name == "left" or votes["mujoco"].answer == mine.answer
    assert votes["pybullet"].answer is not None
    assert mine.options[votes["pybullet"].answer].name == "right"
    assert votes["sapien"].answer is None
    assert votes["sapien"].rejected == "margin: 1.1 where 1.2 apart was required"
    assert votes["pybullet"].value == "right"


def test_disagreement_lists_the_answer_of_every_engine() -> None:
    found = consensus({a.engine: a for a in (label("mujoco", 0), label("pybullet", 1), lost("sapien"))}, "all")
    reported = found["mujoco"]
    assert isinstance(reported, Rejected)
    assert reported.reason == "disagreement"
    assert "sapien rejects it: margin" in reported.detail
    assert found["sapien"].reason == "margin"  # type: ignore[union-attr]
