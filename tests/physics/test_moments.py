"""Where things are between two samples: what is seen in a picture that is taken at any moment."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.engines import ENGINES, installed
from tests.physics.scenes import G, body, scene, turn
from wmspec.sim.scene.model import Glide, Launch, Teleport, Trace
from wmspec.sim.shapes import Sphere

BALL = Sphere(0.05)
WAY = np.array([1.25, 0.0, 0.0])
AWAY = np.array([0.3, 0.0, 0.05])
MOMENTS = st.floats(0, 0.5)


@pytest.fixture(scope="module", params=ENGINES)
def trace(request: pytest.FixtureRequest) -> Trace:
    """One falls and spins, one is carried, one is put elsewhere, and one that is let fall is pushed."""
    named = scene(
        body("falls", BALL, (0, 0, 9), velocity=(2, 0, 0), spin=(0, 0, 5)),
        body("carried", BALL, (0, 1, 0), motion="kinematic"),
        body("put", BALL, (0, 2, 0), motion="kinematic"),
        body("pushed", BALL, (0, 3, 9)),
        duration=0.5,
        actions=(
            Glide("glide", "carried", 0.1, 0.4, WAY),
            Teleport("put", "put", 0.2, AWAY),
            Launch("push", "pushed", 0.25, WAY, np.zeros(3)),
        ),
    )
    made: Trace = installed(request.param).execute(named)
    return made


@given(time=MOMENTS)
def test_moving_body_is_between_two_samples(trace: Trace, time: float) -> None:
    falls, carried, _, pushed = trace.poses(time)
    assert falls.position == pytest.approx((2 * time, 0, 9 - G * time**2 / 2), abs=6e-3), "an engine's own steps"
    assert carried.position == pytest.approx(WAY * np.clip(time - 0.1, 0, 0.3) + (0, 1, 0), abs=1e-6)
    assert pushed.position[0] == pytest.approx(WAY[0] * max(time - 0.25, 0), abs=1e-4)
    assert abs(falls.orientation @ turn((0, 0, 1), 5 * time)) == pytest.approx(1, abs=1e-6)


@given(time=MOMENTS)
def test_teleport_has_no_path(trace: Trace, time: float) -> None:
    assert trace.poses(time)[2].position[0] in (0.0, AWAY[0])


def test_a_sample_is_itself(trace: Trace) -> None:
    for i, time in enumerate(trace.time):
        for k, pose in enumerate(trace.poses(float(time) + 4e-7)):
            np.testing.assert_array_equal(pose.position, trace.position[i, k])
            np.testing.assert_array_equal(pose.orientation, trace.orientation[i, k])


def test_both_quaternions_of_a_turn_are_equal(trace: Trace) -> None:
    flipped = replace(
        trace, orientation=trace.orientation * np.where(np.arange(len(trace.time)) % 2, 1, -1)[:, None, None]
    )
    for one, other in zip(trace.poses(0.3011), flipped.poses(0.3011), strict=True):
        assert abs(one.orientation @ other.orientation) == pytest.approx(1)
