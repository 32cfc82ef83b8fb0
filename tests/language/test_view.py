"""Which way pictures look, and what is on the left in them."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from wmspec.compile.layout.evaluator import Evaluator
from wmspec.compile.layout.view import camera_direction, common_direction, view_coordinates
from wmspec.compile.stage.cameras import _look_at_matrix
from wmspec.lang.check.statements.builder import observe, task, thing

PLACES = st.integers(-100, 100).map(lambda cm: cm / 100)


@given(yaw=st.floats(-math.pi, math.pi), down=st.floats(-1.5, 1.5), x=PLACES, y=PLACES)
def test_to_the_right_is_to_the_right_in_the_picture(yaw: float, down: float, x: float, y: float) -> None:
    """The oracle: the camera's own axes on the stage, within 45 degrees of those that words go by."""
    ahead = (math.cos(down) * math.cos(yaw), math.cos(down) * math.sin(yaw), math.sin(down))
    values = Evaluator(task("t", thing("camera", "eye", at=(0.0, 0.0, 0.0), look_at=ahead), observe("eye", [0])), {})
    assert common_direction(values) == camera_direction(values, "eye")
    right, back = view_coordinates(common_direction(values), x, y)
    across, *_ = _look_at_matrix((0.0, 0.0, 0.0), ahead, values, "eye")
    assert math.hypot(right, back) == pytest.approx(math.hypot(x, y))
    if abs(right) > 1.01 * abs(back):  # at the most turned, what is as far back is level with it
        assert (across[0] * x + across[1] * y) * right > 0


@pytest.mark.parametrize("below", [-1.0, 1.0])
def test_looking_along_the_vertical_is_looking_to_the_front(below: float) -> None:
    values = Evaluator(
        task("t", thing("camera", "eye", at=(1, 2, 3), look_at=(1, 2, 3 + below)), observe("eye", [0])), {}
    )
    assert camera_direction(values, "eye") == 0
