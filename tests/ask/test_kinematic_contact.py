"""Contacts of bodies on paths and fixed ones, of which engines report none: shapes and poses tell."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.ask.asking import ask_all, quick_matrix, run
from tests.ask.test_overlap import SHAPES, at, turns
from tests.examples import examples
from wmspec.runtime.questions.model import QuestionRow
from wmspec.sim.scene.model import Array, Geom, Pose
from wmspec.sim.scene.model.bounds import bounds
from wmspec.sim.scene.model.transform import identity
from wmspec.sim.scene.physics.kinematic_contact import TOUCH_DISTANCE, clearance, first_touch
from wmspec.sim.scene.physics.overlap import overlap, separation
from wmspec.sim.shapes import Box, Shape, Sphere

FLOOR = Box((1.0, 1.0, 0.1))


@examples(12, 30)
@given(st.floats(0.02, 0.1), st.floats(0.02, 0.1), st.floats(-0.02, 0.3), st.floats(0, 6))
def test_the_distance_of_two_spheres(a: float, b: float, gap: float, turn: float) -> None:
    far = a + b + gap
    found = separation(Sphere(a), at(0, 0, 0), Sphere(b), at(far * np.cos(turn), far * np.sin(turn), 0), TOUCH_DISTANCE)
    if gap > TOUCH_DISTANCE:
        assert found == pytest.approx(gap, abs=3e-5)
    else:
        assert found <= TOUCH_DISTANCE + 1e-5


@pytest.mark.parametrize("shape", SHAPES, ids=lambda s: type(s).__name__)
@examples(5, 15)
@given(turn=turns, gap=st.floats(0.001, 0.2))
def test_the_distance_from_a_floor(shape: Shape, turn: tuple[float, ...], gap: float) -> None:
    """It is at most the true one, above 0.1 mm for what is 1 mm apart, and below for what touches."""
    lowest = bounds(shape, at(0, 0, 0, turn))[0, 2]
    for high in (gap, 0.0):
        placed = at(0.1, 0.2, high - lowest, turn)
        found = separation(FLOOR, at(0, 0, -0.1), shape, placed, TOUCH_DISTANCE)
        assert TOUCH_DISTANCE < found <= high + 3e-5 if high else found <= TOUCH_DISTANCE


@pytest.mark.parametrize("shape", SHAPES, ids=lambda s: type(s).__name__)
@examples(10, 25)
@given(
    turn=turns,
    other=st.sampled_from(SHAPES),
    other_turn=turns,
    way=st.tuples(*[st.floats(-0.2, 0.2)] * 3).map(np.array),
)
def test_what_overlaps_has_no_clearance(
    shape: Shape, turn: tuple[float, ...], other: Shape, other_turn: tuple[float, ...], way: Array
) -> None:
    one, two = (shape, at(0, 0, 0, turn)), (other, Pose(way, at(0, 0, 0, other_turn).orientation))
    found = clearance([Geom("one", shape, identity())], one[1], [Geom("two", other, identity())], two[1])
    if overlap(*one, *two, 1e-4) > 0:
        assert found <= TOUCH_DISTANCE
    elif found > TOUCH_DISTANCE:
        # A body that has come nearer by all of its clearance still does not overlap.
        nearer = way - found * way / np.linalg.norm(way)
        assert overlap(*one, other, Pose(nearer, two[1].orientation), 1e-4) == 0


MOVES = """
  object ball {{ shape: sphere  size: 8 cm  color: red  on: table at (-30 cm, 0) }}
  object post {{ shape: box  size: (4 cm, 8 cm, 10 cm)  color: blue  on: table at (10 cm, 0)  {fixed} }}
  action go = {go}
  action odd = {odd}
  horizon 1.5 s
  observe front at [0 s, 0.3 s]
  question touch "Do they touch?" {{ answer contact(ball, post)  may hide [ball, post] }}
  question near "Is it near?" {{ answer distance(ball, post) < 20 cm  may hide [ball, post] }}
"""
GLIDE, NOTHING = "glide(ball, direction: right, speed: 40 cm/s) for 1 s", "paint(ball, color: red) at 0 s"


def values(fixed: str = "fixed: true", go: str = GLIDE, odd: str = NOTHING, engine: str = "mujoco") -> list[str]:
    rows = ask_all(MOVES.format(fixed=fixed, go=go, odd=odd), engine=engine)
    return [row.value for row in rows if isinstance(row, QuestionRow)]


PATHS = [
    ("fixed: true", GLIDE, NOTHING, "yes"),
    ("fixed: true", GLIDE.replace("40", "30"), NOTHING, "no"),
    ("", GLIDE, "glide(post, direction: away, speed: 60 cm/s) for 1 s", "no"),
    ("", GLIDE, "glide(post, direction: left, speed: 5 cm/s) for 0.2 s", "yes"),
    ("fixed: true", GLIDE, "vanish(ball) at 0.3 s", "no"),
    ("fixed: true", GLIDE, "pass_through(ball, post) for 2 s", "no"),
    ("fixed: true", GLIDE, "teleport(ball, to: (10 cm, 20 cm)) at 0.3 s", "no"),
]


@pytest.mark.parametrize(("fixed", "go", "odd", "touches", "engine"), quick_matrix(PATHS, "mujoco", 3))
def test_bodies_on_paths_touch(fixed: str, go: str, odd: str, touches: str, engine: str) -> None:
    assert values(fixed, go, odd, engine)[0] == touches


def test_the_first_touch_is_that_of_the_path() -> None:
    """The ball is 34 cm from the post, and comes at 40 cm/s."""
    made = run(MOVES.format(fixed="fixed: true", go=GLIDE, odd=NOTHING))
    samples = slice(0, len(made.trace.time))
    assert first_touch(made.scene, made.trace, "ball", "post", samples) == pytest.approx(0.85, abs=0.005)
    assert first_touch(made.scene, made.trace, "post", "ball", samples) == pytest.approx(0.85, abs=0.005)
    assert first_touch(made.scene, made.trace, "ball", "post", slice(0, 60)) is None
    assert first_touch(made.scene, made.trace, "post", "table", samples) == 0.0
