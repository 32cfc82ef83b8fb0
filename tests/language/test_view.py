"""Which way pictures look, and what is on the left in them."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from wmspec.compile.layout.values import Values
from wmspec.compile.layout.view import facing, front, seen
from wmspec.compile.stage.cameras import _looking
from wmspec.lang.check.statements.builder import observe, task, thing

PLACES = st.integers(-100, 100).map(lambda cm: cm / 100)


@given(yaw=st.floats(-math.pi, math.pi), down=st.floats(-1.5, 1.5), x=PLACES, y=PLACES)
def test_to_the_right_is_to_the_right_in_the_picture(yaw: float, down: float, x: float, y: float) -> None:
    """The oracle: the camera's own axes on the stage, within 45 degrees of those that words go by."""
    ahead = (math.cos(down) * math.cos(yaw), math.cos(down) * math.sin(yaw), math.sin(down))
    values = Values(task("t", thing("camera", "eye", at=(0.0, 0.0, 0.0), look_at=ahead), observe("eye", [0])), {})
    assert front(values) == facing(values, "eye")
    right, back = seen(front(values), x, y)
    across, *_ = _looking((0.0, 0.0, 0.0), ahead, values, "eye")
    assert math.hypot(right, back) == pytest.approx(math.hypot(x, y))
    if abs(right) > 1.01 * abs(back):  # at the most turned, what is as far back is level with it
        assert (across[0] * x + across[1] * y) * right > 0


@pytest.mark.parametrize("below", [-1.0, 1.0])
def test_looking_along_the_vertical_is_looking_to_the_front(below: float) -> None:
    values = Values(task("t", thing("camera", "eye", at=(1, 2, 3), look_at=(1, 2, 3 + below)), observe("eye", [0])), {})
    assert facing(values, "eye") == 0
