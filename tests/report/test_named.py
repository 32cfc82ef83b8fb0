"""Options name objects and properties: answers compare by the object, errors by the property chosen."""

from __future__ import annotations

import pandas as pd
import pytest

from tests.report.conftest import Made
from tests.report.made import Rater, answers
from wmspec.eval.report.entanglement import entanglement
from wmspec.eval.report.named import look_of, object_named, properties, true_properties
from wmspec.eval.report.preferences import preferences
from wmspec.eval.report.questions import Questions
from wmspec.eval.report.replies import replies

SCENE: list[dict[str, object]] = [
    {"picture": 0, "name": name, "look": look, "asked": queried, "x": 0.0, "y": 0.0, "z": 0.1}
    for name, look, queried in (
        ("far", "blue cylinder plastic", True),
        ("near", "purple cylinder wood", True),
        ("box", "white box", False),
        ("other", "white sphere", False),
    )
]


@pytest.mark.parametrize(
    ("words", "name"),
    [
        ("the blue cylinder", "far"),
        ("the purple one", "near"),
        ("blue", ""),  # a colour, not an object
        ("the blue", ""),
        ("the white box", ""),  # two are white, and the words for shapes are not always those of the look
        ("neither", ""),
        ("the blue or the purple cylinder", ""),
    ],
)
def test_words_name_an_object(words: str, name: str) -> None:
    assert object_named(words, SCENE) == name


def test_look_is_that_of_the_true_or_questioned_object() -> None:
    row = {
        "context_objects": SCENE,
        "option_text": ["the blue cylinder", "the purple cylinder", "neither"],
        "answer": 1,
    }
    assert look_of(row) == {"color": "purple", "shape": "cylinder", "material": "wood"}
    assert look_of(row | {"answer": 2}) == {}, "the question is about two objects"
    one = [SCENE[0], *SCENE[2:]]
    assert look_of({"context_objects": one, "option_text": None, "answer": 0})["color"] == "blue"


def test_words_name_a_group_of_objects() -> None:
    """The words "more red apples" are the same answer in all colors: they name a group of objects."""
    scene = [
        {"picture": 0, "name": f"{group}_{n}", "look": look, "asked": True, "x": 0.0, "y": 0.0, "z": 0.1}
        for group, look in (("some", "red apple"), ("others", "blue apple"))
        for n in range(3)
    ]
    scene.append({"picture": 0, "name": "book", "look": "red box", "asked": False, "x": 0.0, "y": 0.0, "z": 0.1})
    assert object_named("more red apples", scene) == "some"
    row = {"context_objects": scene, "option_text": ["the same number", "more blue apples"], "answer": 1}
    assert look_of(row) == {"color": "blue"}
    assert look_of(row | {"answer": 0}) == {}


def test_of_several_objects_the_look_is_that_of_the_mover() -> None:
    places = [
        ("ball", "red sphere", 0.0, 0.4, True),
        ("box", "blue cube", 1.0, 1.0, True),
        ("car", "", 5.0, 6.0, False),
    ]
    scene = [
        {"picture": n, "name": name, "look": look, "asked": queried, "x": (first, last)[n], "y": 0.0, "z": 0.1}
        for n in (0, 1)
        for name, look, first, last, queried in places
    ]
    row = {"context_objects": scene, "option_text": None, "answer": 2}
    assert look_of(row) == {"color": "red", "shape": "sphere"}
    assert look_of(row | {"context_objects": [o | {"x": 0.0} for o in scene]}) == {}


def test_options_have_levels() -> None:
    assert properties("to the left", None) == {"position": "left"}
    assert properties("the red cube", None) == {"color": "red", "shape": "cube"}
    assert properties("the left or the right one", None) == {}
    changes = ("state start: low -> high; action pace: slow -> fast", None, "action pace: slow -> fast")
    assert properties(None, changes[0]) == {"start": "high", "pace": "fast"}
    assert true_properties(changes) == {"start": "low", "pace": "slow"}


def test_bias_to_one_outcome_is_signed(made: Made) -> None:
    """A rater who errs to the higher speed has a bias to that level, and against the true one."""
    high = Rater(
        "hasty",
        lambda row: 0.3,
        wrongly=lambda row: [0.01 + (change or "").startswith("action") for change in row["option_change"]],
    )
    known = Questions.read(made.folder)
    found = [p for p in preferences(replies(answers(made.rows, high), known)) if p.system == "hasty"]
    assert found
    for p in found:
        assert p.bias.value == pytest.approx(p.chosen - p.true)
        assert -1 <= (p.bias.low or -1) <= p.bias.value <= (p.bias.high or 1) <= 1
    sums = pd.DataFrame([(p.task, p.dimension, p.bias.value) for p in found]).groupby([0, 1])[2].sum()
    assert sums.abs().max() < 1e-9, "what is chosen more often stands in place of something else"


def test_entanglement_has_intervals_and_a_null_band(made: Made) -> None:
    found = {(e.system, e.task, e.factor): e for e in entanglement(made.replies)}
    red = found["entangled", "race", "color"]
    assert red.low is not None
    assert red.high is not None
    assert red.low <= red.value <= red.high
    assert red.low > red.bound, "its interval is beyond what shuffled levels yield"
    ideal = found["ideal", "race", "color"]
    assert 0 <= ideal.least <= ideal.mean <= ideal.bound
    assert ideal.value < 2 * ideal.bound
