"""Findings from the rows alone: companion questions, vocabulary, motion, and answers that never change."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from itertools import product
from typing import Any

import pytest

from wmspec.dataset.audit.cases import Case, Unit
from wmspec.dataset.audit.constant_answers import constant_answer_finding, what_if_finding
from wmspec.dataset.audit.given import companion_finding, given_by, given_in_words, required_moments, varied_factors
from wmspec.dataset.audit.legibility import motion_finding
from wmspec.dataset.audit.model import Finding
from wmspec.dataset.audit.vocabulary import vocabulary_finding
from wmspec.runtime.questions.legibility.bounds import BOUNDS, REFERENCE_SIDE

WEIGHTS, WAYS = ("light", "heavy"), ("left", "right")
LEVELS = list(product(WEIGHTS, WAYS))


def rows(name: str, make: Callable[[int, str, str], dict[str, Any]], groups: int = 12) -> Unit:
    """A unit of closed groups; `make` returns the columns of a row from its group and its levels."""
    cases = [
        Case(
            {
                "id": f"t/{4 * group + place:06d}/q0",
                "index": 4 * group + place,
                "block": group,
                "crossed": ["weight", "way"],
                "factor.weight": weight,
                "factor.way": way,
                "text": "What next?",
                "context_camera": ["front"],
                "context_time": [0.0],
                "answer_standing": False,
                "answer_moments": 2,
                **make(group, weight, way),
            },
            (),
            (),
        )
        for group in range(groups)
        for place, (weight, way) in enumerate(LEVELS)
    ]
    return Unit(name, tuple(cases), ("mujoco",))


def labelled(options: Sequence[str], answer: str, **more: Any) -> dict[str, Any]:
    return {
        "option_kind": ["truth" if o == answer else "label" for o in options],
        "option_name": list(options),
        "option_text": list(options),
        "answer": list(options).index(answer),
        **more,
    }


def pictured(text: str) -> Unit:
    """Units with closed sets of pictures; `text` has places for the weight and the way."""

    def make(_group: int, weight: str, way: str) -> dict[str, Any]:
        changes = []
        for other_weight, other_way in LEVELS:
            parts = [f"state weight: {weight} -> {other_weight}"] * (other_weight != weight)
            parts += [f"action way: {way} -> {other_way}"] * (other_way != way)
            changes.append("; ".join(parts) or None)
        place = LEVELS.index((weight, way))
        names = [f"{a}_{b}" for a, b in LEVELS]
        return {
            "text": text.format(weight=weight, way=way),
            "option_change": changes,
            "option_kind": ["truth" if change is None else "state" for change in changes],
            "option_name": names,
            "option_text": None,
            "answer": place,
        }

    made = rows("t q0", make)
    return replace(made, cases=tuple(Case(c.row, (b"",), (b"",) * 4) for c in made.cases))


def probed_names(factor: int) -> Unit:
    """A companion question about the weight (0) or the way (1)."""
    return rows("t q1", lambda group, *levels: labelled(LEVELS[0] + LEVELS[3], levels[factor]))


def bystander() -> Unit:
    return rows("t q2", lambda group, weight, way: labelled(["red", "blue"], "red" if group % 2 else "blue"))


def test_levels_are_given_in_words_or_by_companions() -> None:
    question, weight, way, other = pictured("It is {weight}."), probed_names(0), probed_names(1), bystander()
    assert varied_factors(question.cases) == {"way": "action", "weight": "state"}
    assert [given_in_words(question, name) for name in ("weight", "way")] == [True, False]
    assert given_by([question, weight, other], question, "weight") == [weight.name]
    assert given_by([question, weight, other], question, "way") == []
    assert given_by([question, way], question, "way") == [way.name]


@pytest.mark.parametrize(
    ("text", "companions", "verdict", "words"),
    [
        ("It is {weight}.", [bystander()], "fails", "no companion question concerns `way`"),
        ("What next?", [bystander()], "fails", "no companion question concerns `way` and `weight`"),
        ("It is {weight}.", [probed_names(1), bystander()], "holds", "`weight` in the text"),
        ("What next?", [probed_names(1), probed_names(0)], "holds", "`weight` by "),
        ("It is {weight} and goes {way}.", [bystander()], "holds", "`way` in the text"),
    ],
)
def test_companions_concern_what_the_options_vary(text: str, companions: list[Unit], verdict: str, words: str) -> None:
    question = pictured(text)
    found = companion_finding([question, *companions], question)
    assert found is not None
    assert found.verdict == verdict
    assert words in found.what


def test_a_prediction_requires_as_many_moments_as_its_companions() -> None:
    def standing(unit: Unit) -> Unit:
        return replace(unit, name="t q3", cases=tuple(case.requiring(1) for case in unit.cases))

    question, weight, way = pictured("What next?"), probed_names(0), probed_names(1)
    weight = replace(weight, name="t q4", cases=tuple(case.requiring(1) for case in weight.cases))
    assert required_moments([question, weight, way], question) == 2  # the way is a motion
    assert required_moments([question, weight, standing(way)], question) == 1  # any picture shows both
    assert required_moments([question, weight, way, standing(way)], question) == 1
    assert required_moments([question, weight, bystander()], question) is None
    assert required_moments([pictured("It is {weight}."), way], pictured("It is {weight}.")) == 2
    assert required_moments([way, question], way) is None


def test_without_companions_or_closed_sets_there_is_no_finding() -> None:
    question, other = pictured("What next?"), bystander()
    assert companion_finding([question], question) is None
    assert companion_finding([question, other], other) is None


def vocabulary(options: Sequence[str]) -> Finding:
    found = vocabulary_finding(rows("t", lambda group, weight, way: labelled(options, options[0])))
    assert found is not None
    return found


def test_options_that_overlap_fail() -> None:
    found = vocabulary(["brick", "planks", "leather", "wood"])
    assert found.verdict == "fails"
    assert found.what.startswith("48 of 48 questions (100%) offer words that overlap: `planks` is a kind of `wood`")
    assert vocabulary(["brick", "marble", "leather", "wood"]).verdict == "holds"


def moving(step: float, **more: Any) -> Finding | None:
    """What is found if a ball moves by a step (px) between two pictures."""

    def make(_group: int, _weight: str, way: str) -> dict[str, Any]:
        objects = [
            {
                "picture": i,
                "name": "ball",
                "look": "",
                "share": 0.02,
                "across": 0.4 + i * step / REFERENCE_SIDE,
                "down": 0.5,
            }
            for i in range(2)
        ]
        shown = {"context_camera": ["front", "front"], "context_time": [0.0, 0.1], "context_objects": objects}
        return labelled(WAYS, way) | shown | more

    made = rows("t", make)
    return motion_finding(replace(made, cases=tuple(Case(c.row, (b"", b""), ()) for c in made.cases)))


@pytest.mark.parametrize(("step", "verdict"), [(0.9, "fails"), (1.1, "holds")])
def test_motion_must_be_seen(step: float, verdict: str) -> None:
    found = moving(step * BOUNDS["step"].value)
    assert found is not None
    assert found.verdict == verdict


def test_legibility_of_motion_needs_an_answer_on_motion() -> None:
    assert moving(1.0, answer_standing=True) is None
    assert moving(1.0, answer_moments=1) is None
    assert moving(1.0, legibility=[]) is None
    assert moving(1.0, **labelled(["yes", "no"], "no")) is None


def answered(answer: Callable[[int, str], str], tiers: Callable[[int, str], float | None]) -> Finding | None:
    def make(group: int, _weight: str, way: str) -> dict[str, Any]:
        tier = tiers(group, way)
        difference = None if tier is None else {"name": "hue", "unit": "deg", "value": tier}
        return labelled(["yes", "no"], answer(group, way), difference=difference)

    return constant_answer_finding(rows("t", make, 24))


def test_constant_answer_of_a_tier_is_found() -> None:
    def yes_in_tier_2(group: int, way: str) -> str:
        return "yes" if way == "left" or (group % 2 and group % 8 > 1) else "no"

    found = answered(yes_in_tier_2, lambda group, way: 1.0 + group % 2)
    assert found is not None
    assert found.verdict == "fails"
    assert found.what.startswith("always `yes` is right in ")
    assert "of tier hue = 2 deg" in found.what


def test_equal_answers_in_every_tier_hold() -> None:
    found = answered(lambda group, way: "yes" if way == "left" else "no", lambda group, way: 1.0 + group % 2)
    assert found is not None
    assert found.verdict == "holds"


def test_chance_is_that_among_the_answers_of_a_tier() -> None:
    """Equal things have a tier of their own, so of three answers two occur in each other tier."""

    def compared(share: int) -> Finding | None:
        def make(group: int, weight: str, way: str) -> dict[str, Any]:
            answer = ("more" if way == "left" or group % share == 0 else "fewer") if weight == "light" else "equal"
            difference = {"name": "number", "unit": "", "value": 1.0 if weight == "heavy" else 2.0}
            return labelled(["more", "fewer", "equal"], answer, difference=difference)

        return constant_answer_finding(rows("t", make, 240))

    even, skewed = compared(1000), compared(2)
    assert even is not None
    assert even.verdict == "holds"
    assert skewed is not None
    assert skewed.verdict == "fails"
    assert "(chance 50%" in skewed.what


def test_tiers_of_one_answer_are_left_out() -> None:
    """Two things that are the same have no difference, and no tier."""
    found = answered(
        lambda group, way: "yes" if way == "left" else "no",
        lambda group, way: None if way == "left" else 1.0 + group % 2,
    )
    assert found is None


@pytest.mark.parametrize(
    ("actual", "verdict"),
    [(lambda answer, _: answer, "unclear"), (lambda answer, _: {"yes": "no", "no": "yes"}[answer], "unclear"),
     (lambda _, weight: "yes" if weight == LEVELS[0][0] else "no", "holds"), (lambda *_: None, None)],
)  # fmt: skip
def test_what_if_answers_differ_from_actual_ones(actual: Callable[[str, str], str | None], verdict: str | None) -> None:
    def make(_: int, weight: str, way: str) -> dict[str, Any]:
        answer = "yes" if way == "left" else "no"
        return labelled(["yes", "no"], answer, answer_value=answer, actual_value=actual(answer, weight))

    found = what_if_finding(rows("t", make, 24))
    assert (found.verdict if found else None) == verdict
