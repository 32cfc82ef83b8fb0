"""What is hidden when the episode begins: reported where one box hides all of it from every camera in use."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

import wmspec
from tests.examples import examples
from wmspec.compile.lint.hidden_rules import _is_between
from wmspec.core.space import Pose, from_ypr

SPEC = """use room

task hidden : custom {{
  factor tone in [red, blue]
  object wall {{ shape: {shape}  at: ({x} cm, -20 cm, 25 cm)  fixed: true  drawn: {drawn} }}
  object ball {{ shape: sphere  size: 14 cm  color: tone  on: floor at (0, 0) }}
  observe front at [{time} s]
  {more}
  question "Which colour has the ball?" {{ options [red, blue]  answer {answer} }}
}}
"""
BOX = "box  size: (50 cm, 2 cm, 50 cm)"


def reported(
    x: int = 0, drawn: str = "true", time: int = 0, more: str = "", answer: str = "ball.color", shape: str = BOX
) -> bool:
    text = SPEC.format(x=x, drawn=drawn, time=time, more=more, answer=answer, shape=shape)
    warnings = [str(d) for d in wmspec.diagnose(text=text).diagnostics if d.code == "WMS605"]
    return any("hidden behind `wall`" in warning for warning in warnings)


@pytest.mark.parametrize("answer", ["ball.color", "tone"])
def test_hidden_answer_is_reported_under_any_name(answer: str) -> None:
    assert reported(answer=answer)


@pytest.mark.parametrize(
    "seen",
    [
        {"x": 24},  # half of it looks out
        {"drawn": "false"},
        {"time": 1},  # by then it may have come out
        {"more": "observe top at [0 s]"},
        {"shape": "sphere  size: 50 cm"},  # what is no box is not judged
    ],
    ids="".join,
)
def test_visible_answers_are_not_reported_as_hidden(seen: dict[str, object]) -> None:
    assert not reported(**seen)  # type: ignore[arg-type]


COORDINATE = st.floats(-2, 2).map(lambda x: round(x, 2))
POINT = st.tuples(COORDINATE, COORDINATE, COORDINATE)


@examples(300, 3000)
@given(eye=POINT, point=POINT, yaw=st.floats(-math.pi, math.pi))
def test_a_box_between_two_points_has_a_point_of_the_way_between_them(
    eye: tuple[float, float, float], point: tuple[float, float, float], yaw: float
) -> None:
    half = (0.5, 0.3, 0.4)
    pose = Pose((0.1, 0.2, 0.3), from_ypr(yaw, 0.0, 0.0))
    inside = [
        _inside(tuple(a + (b - a) * i / 200 for a, b in zip(eye, point, strict=True)), half, yaw) for i in range(201)
    ]
    border = tuple(edge + 1e-9 for edge in half)
    if any(inside[1:]) and not _inside(eye, border, yaw):
        assert _is_between(eye, point, half, pose)
    if _is_between(eye, point, half, pose):
        grown = tuple(edge + 0.05 for edge in half)
        steps = (tuple(a + (b - a) * i / 200 for a, b in zip(eye, point, strict=True)) for i in range(201))
        assert any(_inside(step, grown, yaw) for step in steps)


def _inside(point: tuple[float, ...], half: tuple[float, ...], yaw: float) -> bool:
    """Whether a point is within the box of the test, by its own sines and cosines."""
    x, y, z = (a - b for a, b in zip(point, (0.1, 0.2, 0.3), strict=True))
    local = (x * math.cos(yaw) + y * math.sin(yaw), -x * math.sin(yaw) + y * math.cos(yaw), z)
    return all(abs(a) < edge for a, edge in zip(local, half, strict=True))
