"""Directions are compared the shorter way round: what goes left has a heading like any other."""

from __future__ import annotations

import math
import pickle

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.ask.asking import one, refused
from wmspec.compile.layout.functions import FUNCTIONS
from wmspec.runtime.questions.bearing import ROUNDING, Bearing
from wmspec.runtime.questions.kinds.labels import same
from wmspec.runtime.questions.kinds.numbers import NumberAnswer, Numbers
from wmspec.runtime.questions.verbalize import verbalize

ANGLES = st.floats(-50, 50)


@given(a=ANGLES, b=ANGLES, turns=st.integers(-5, 5))
def test_a_whole_turn_makes_no_difference(a: float, b: float, turns: int) -> None:
    one, other = Bearing(a), Bearing(a + turns * 2 * math.pi)
    assert -math.pi + ROUNDING <= one <= math.pi
    assert abs(one - other) < 1e-9
    assert abs(one - b) == pytest.approx(abs(b - one)) == pytest.approx(abs(Bearing(a - b)), abs=1e-9)
    assert math.cos(one + b) == pytest.approx(math.cos(a + b), abs=1e-9)
    assert math.sin(b - one) == pytest.approx(math.sin(b - a), abs=1e-9)
    assert abs(one - b) <= math.pi


def test_the_other_way_has_one_number() -> None:
    assert Bearing(-math.pi) == Bearing(math.pi) == -Bearing(math.pi) == math.pi
    assert Bearing(1e-7 - math.pi) == math.pi
    assert type(pickle.loads(pickle.dumps(Bearing(1.0)))) is Bearing


@pytest.mark.parametrize(
    ("degrees", "said"), [(-179.99, "180°"), (-180, "180°"), (179.99, "180°"), (-179.5, "-179.5°")]
)
def test_bearing_is_verbalized_in_one_way(degrees: float, said: str) -> None:
    assert verbalize(Bearing(math.radians(degrees)), "angle", None) == said  # type: ignore[arg-type]


def test_it_is_an_option_in_every_turn() -> None:
    assert same(math.radians(-180), Bearing(math.pi))
    assert same(math.radians(540), Bearing(math.pi))
    assert not same(math.radians(-179), Bearing(math.pi))


def test_its_multiples_are_plain_numbers() -> None:
    assert FUNCTIONS["mod"](None, Bearing(math.radians(-10)), math.radians(360)) == pytest.approx(math.radians(350))


def test_engines_agree_on_either_side_of_the_cut() -> None:
    def answer(degrees: float) -> NumberAnswer:
        return NumberAnswer(Bearing(math.radians(degrees)), math.radians(5))

    assert Numbers().agree(answer(179), answer(-178))
    assert not Numbers().agree(answer(179), answer(-175))


LEFT = """
  object a {{ shape: cube  size: 8 cm  color: red   on: table at (20 cm, 8 cm) }}
  object b {{ shape: cube  size: 8 cm  color: blue  on: table at (20 cm, -8 cm) }}
  action p = launch(a, direction: {a} deg, speed: 50 cm/s)
  action q = launch(b, direction: {b} deg, speed: 50 cm/s)
  horizon 0.4 s
  observe top at [0 s, 0.4 s]
  question "Which way does the red cube go?" {{ answer heading(a)  {gates} }}
"""


def test_cube_that_goes_left_keeps_its_question() -> None:
    """Nudged, pybullet's cube is now just above -180 degrees and now just below 180."""
    question = one(LEFT.format(a=180, b=180, gates="within 5 deg  stable by 1 mm"))
    assert question.value == "180°"


def test_differences_and_margins_go_the_shorter_way() -> None:
    gates = "within 5 deg  difference heading(a) - heading(b)  margin heading(a) - heading(b) apart by %s deg"
    question = one(LEFT.format(a=178, b=-178, gates=gates % 2))
    assert question.difference is not None
    assert math.degrees(question.difference.value) == pytest.approx(-4, abs=0.5)
    assert question.margin == pytest.approx(2, abs=0.25)
    assert refused(LEFT.format(a=178, b=-178, gates=gates % 6)).startswith("margin: ")
