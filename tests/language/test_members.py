"""Members of a set at an index that depends on factors, and measures of each member."""

from __future__ import annotations

import pytest

from tests.ask.asking import ask_all, one, spec_of
from wmspec.compile.design.design import Design
from wmspec.compile.layout.evaluator import Evaluator
from wmspec.core.diagnostics import SpecError, WmsError
from wmspec.runtime.questions.model import QuestionRow
from wmspec.runtime.questions.verbalize import format_expression

BALLS = """
  factor target in [0, 1, 2]
  nuisance pace[3] in [30, 40, 50] cm/s
  objects balls[3] {
    shape: sphere  size: 8 cm  color: pick([red, blue, green], index)  on: table at (15 cm * index - 15 cm, 0)
  }
"""


def test_a_factor_selects_the_member_that_acts_and_that_a_question_names() -> None:
    body = BALLS + """
  action go = launch(balls[target], direction: away, speed: pace[target], rolling: true) at 0.1 s
  observe front at [0 s, 0.4 s]
  question "Which one moves?" { options [balls[0], balls[1], balls[2]]  answer mover([balls[0], balls[1], balls[2]]) }
  question "Does {balls[target]} move?" { answer moved(balls[target]) }
"""  # fmt: skip
    design = Design(spec_of(body))
    for index in range(3):
        which, does = ask_all(body, index)
        assert isinstance(which, QuestionRow)
        assert isinstance(does, QuestionRow)
        target = [0.0, 1.0, 2.0].index(float(str(design[index].factors["target"])))
        colour = ("red", "blue", "green")[target]
        assert (which.value, does.value) == (f"the {colour} sphere", "yes")
        assert f"the {colour} sphere" in does.text
    answer = design.spec.questions[1].answer
    assert format_expression(answer) == "moved(balls[target])"


@pytest.mark.parametrize("index", ["target + 1", "target - 1", "target / 2"])
def test_an_index_that_is_no_member_is_an_error(index: str) -> None:
    spec = spec_of(BALLS + f"  let chosen = balls[{index}]\n observe front at [0 s]")
    values = [Evaluator(spec, {"target": float(n)}) for n in (0, 1, 2)]
    with pytest.raises(WmsError, match=r"no whole number from 0 to 2"):
        [own.ref("chosen") for own in values]


def test_the_index_of_an_action_is_constant() -> None:
    with pytest.raises(SpecError, match="the index of an action must be constant"):
        spec_of(
            BALLS
            + """
  actions roll[3] = launch(balls[index], direction: away, speed: 1 m/s) at 0.1 s
  action halt = stop(balls[0]) after roll[target]
  observe front at [0 s]
"""
        )


def test_positions_of_several_are_compared() -> None:
    """Of a set, `position(balls).x` has one number for each member."""
    body = (
        BALLS
        + """
  observe front at [0 s]
  question "Is the red one on the left?" { answer position(balls[0]).x <= min(position(balls).x) }
"""
    )
    assert one(body).value == "yes"
    assert one(body.replace("balls[0])", "balls[1])")).value == "no"
    counted = body.replace("position(balls[0]).x <= min(position(balls).x)", "any(position(balls).x > 10 cm)")
    assert one(counted).value == "yes"


TURNED = """
  factor way in [left, right]
  object ball {{ shape: sphere  size: 8 cm  color: red  on: table at (0, 0) }}
  action go = launch(ball, direction: {direction}, speed: 50 cm/s, rolling: true)
  horizon 0.5 s
  observe top at [0 s]
  question "Which comes?" {{
    answer frame(top, end)
    counterfactual other {{ action go.direction: {other} }}
    distinct by 3 cm
  }}
"""


@pytest.mark.parametrize("direction", ["left", "way", "180 deg", "if way == left then left else right"])
@pytest.mark.parametrize("other", ["go.direction + 90 deg", "opposite(go.direction)", "-go.direction + 20 deg"])
def test_a_direction_word_is_an_angle_in_a_change(direction: str, other: str) -> None:
    assert len(one(TURNED.format(direction=direction, other=other)).options) == 2


def test_the_same_direction_is_no_change() -> None:
    with pytest.raises(SpecError, match="the value without the counterfactual"):
        spec_of(TURNED.format(direction="left", other="go.direction"))


@pytest.mark.parametrize(
    ("angle", "help"), [("left + 10 deg", "write its angle, `180 deg`"), ("way + 10 deg", "right is 0 deg")]
)
def test_arithmetic_with_a_direction_word_has_a_remedy(angle: str, help: str) -> None:
    with pytest.raises(SpecError) as caught:
        spec_of(TURNED.format(direction="left", other=angle))
    assert help in caught.value.diagnostics[0].help
