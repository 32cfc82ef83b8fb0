"""What decides an answer is measured as it is drawn, in pixels that do not depend on the size of the picture."""

from __future__ import annotations

import math

import numpy as np
import pytest

from tests.ask.asking import SCENE, pair, run, spec_of
from tests.language.specs import task_from
from wmspec.compile.design.design import Design
from wmspec.runtime.questions.ask import ask
from wmspec.runtime.questions.legibility.bounds import BOUNDS, entry, ratio
from wmspec.runtime.questions.legibility.color_vision import dichromat_difference, difference
from wmspec.runtime.questions.legibility.labels import texture_difference
from wmspec.runtime.questions.legibility.motion import drawn_path
from wmspec.runtime.questions.legibility.picture_places import center, pixels_per_metre
from wmspec.runtime.questions.model import QuestionRow, Rejected

GLIDE = """
object ball {{ shape: cube  size: 8 cm  color: red  on: table at (-20 cm, 0) }}
object other {{ shape: cube  size: 8 cm  color: {color}  on: table at (-20 cm, 25 cm) }}
action go = glide(ball, direction: right, speed: {speed} cm/s) for 2 s
action too = glide(other, direction: right, speed: {other} cm/s) for 2 s
observe top at 0 s .. 2 s in 3 frames
question "Which is faster?" {{ options [ball, other]  answer fastest([ball, other]) }}
"""


def measures(body: str, side: int = 128) -> dict[str, float]:
    """The measures of the only question, which is kept."""
    (row,) = ask(Design(spec_of(body)), 0, pair(side=side))
    assert isinstance(row, QuestionRow), row
    return {each.name: each.value for each in row.legibility}


def glide(speed: float = 12, other: float = 6, color: str = "blue", side: int = 128) -> dict[str, float]:
    return measures(GLIDE.format(speed=speed, other=other, color=color), side)


@pytest.mark.parametrize("speed", [2, 5, 14])
def test_a_mover_is_measured_by_how_far_it_is_drawn_from_where_it_was(speed: float) -> None:
    observed = run(GLIDE.format(speed=speed, other=1, color="blue")).observed(
        [("top", 0.0), ("top", 1.0), ("top", 2.0)], pair()
    )
    path = drawn_path(observed, "ball", "top", (0.0, 1.0, 2.0))
    metre = pixels_per_metre(observed, "ball", ("top", 1.0))
    assert path.length == pytest.approx(metre * speed / 50, abs=6)  # a pixel of 128 is 3 of 384
    assert path.step == pytest.approx(path.length / 2, abs=4)
    assert path.step_in_widths == pytest.approx(speed / 8, rel=0.2, abs=0.1)


def test_the_path_of_a_body_leads_through_pictures_that_hide_it() -> None:
    body = """
    object screen { shape: box  size: (16 cm, 2 cm, 24 cm)  color: gray  on: table at (0, -12 cm)  fixed: true }
    object ball { shape: cube  size: 8 cm  color: red  on: table at (-24 cm, 0) }
    action go = glide(ball, direction: right, speed: 24 cm/s) for 2 s
    observe front at [0 s, 1 s, 2 s]
    """
    observed = run(body).observed([("front", 0.0), ("front", 1.0), ("front", 2.0)], pair())
    assert center(observed.picture("front", 1.0), observed.index("ball")) is None
    through, across = (drawn_path(observed, "ball", "front", times) for times in ((0.0, 1.0, 2.0), (0.0, 2.0)))
    assert (through.step, through.step_in_widths) == (across.step, across.step_in_widths)
    assert through.travelled.tolist() == [0.0, 0.0, across.length]
    assert across.length > 60


def test_measures_do_not_depend_on_the_size_of_the_picture() -> None:
    small, large = glide(side=128), glide(side=384)
    assert small.keys() == large.keys() >= {"step", "step_in_widths", "path", "lead", "size", "color"}
    for name, value in large.items():
        tolerance = 6 if BOUNDS[name].unit == "px" else 2
        assert small[name] == pytest.approx(value, rel=0.06, abs=tolerance), name


def test_smaller_lead_is_less_legible() -> None:
    leads = [glide(other=other)["lead"] for other in (2, 6, 11)]
    assert leads == sorted(leads, reverse=True)
    assert leads[1] == pytest.approx(glide()["path"], rel=0.1, abs=4)  # one is twice as fast


def test_slower_of_two_movers_decides() -> None:
    assert glide(speed=12, other=3)["step"] == pytest.approx(glide(speed=3, other=12)["step"], abs=4)
    assert glide(speed=12, other=3)["step"] < glide(speed=12, other=6)["step"]


def test_names_of_colours_are_compared_as_drawn() -> None:
    near, far = glide(color="orange"), glide(color="blue")
    assert near["color"] < far["color"]
    assert near["color_dichromat"] < far["color_dichromat"]


@pytest.mark.parametrize(("taken", "expected"), [("true", {"place"}), ("false", {"length"})])
def test_only_the_branch_that_is_taken_counts(taken: str, expected: set[str]) -> None:
    body = f"""
    factor look in [{taken}]
    object a {{ shape: cube  size: 10 cm  color: red  on: table at (-15 cm, 0) }}
    object b {{ shape: cube  size: 8 cm  color: blue  on: table at (15 cm, 0) }}
    observe front at [0 s]
    question "?" {{
      options [true, false]
      answer  if look then relation(a, b) == left_of else largest([a, b]) == a
    }}
    """
    found = measures(body)
    assert found.keys() & {"place", "length"} == expected


def test_count_measures_number_and_size() -> None:
    body = """
    objects ball[5] {
      shape: sphere  size: if index == 2 then 4 cm else 6 cm  color: red  on: table at (-30 cm + 12 cm * index, 0)
    }
    observe front at [0 s]
    question "How many balls are there?" { options [4, 5]  answer count(ball) }
    """
    found = measures(body)
    assert found["number"] == 5
    assert found["size"] == pytest.approx(measures(body.replace("6 cm", "4 cm"))["size"], rel=0.2)


def test_a_bound_from_above_is_met_by_less() -> None:
    assert ratio(entry("number", 30)) == 1
    assert ratio(entry("number", 60)) == 0.5
    assert ratio(entry("step", 6)) == 0.5
    assert math.isinf(ratio(entry("number", 0)))


def test_dichromats_confuse_red_and_green_but_not_blue_and_yellow() -> None:
    red, green = (0.6, 0.3, 0.1), (0.35, 0.42, 0.1)
    assert dichromat_difference(red, green) < difference(red, green) / 2
    assert dichromat_difference((0.1, 0.2, 0.9), (0.9, 0.8, 0.1)) > 40
    for gray in (0.1, 0.5, 0.9):
        assert dichromat_difference((gray,) * 3, (1, 1, 1)) == pytest.approx(
            difference((gray,) * 3, (1, 1, 1)), abs=0.1
        )


def test_texture_differs_by_spread_and_grain_not_by_lightness() -> None:
    from wmspec.sim.scene.model import Frame

    def texture(left: np.ndarray, right: np.ndarray) -> float:
        rgb = np.repeat(np.hstack([left, right])[..., None], 3, axis=2).astype(np.uint8)
        ids = np.repeat([[0] * 32 + [1] * 32], 32, axis=0).astype(np.int16)
        return texture_difference(Frame(rgb, ids), 0, 1)

    rows, columns = np.indices((32, 32))
    flat, fine, coarse = np.full((32, 32), 128), (rows + columns) % 2 * 80 + 80, (columns // 8) % 2 * 80 + 80
    assert texture(flat, flat + 60) == pytest.approx(0, abs=1e-9)
    assert texture(fine, fine) == pytest.approx(0, abs=1e-9)
    assert texture(flat, fine) > BOUNDS["texture"].value
    assert texture(coarse, fine) > BOUNDS["texture"].value


def test_illegible_question_is_rejected_unless_off() -> None:
    body = GLIDE.format(speed=3, other=1, color="blue")
    (rejected,) = ask(Design(task_from(SCENE.format(body=body))), 0, pair())
    assert isinstance(rejected, Rejected)
    assert rejected.reason == "illegible"
    assert "`step` of other is" in rejected.detail
    assert "must be at least 12 px" in rejected.detail
    assert rejected.answer == "the red cube"
    (kept,) = ask(Design(task_from(SCENE.format(body=body.replace("options", "legibility off  options")))), 0, pair())
    assert isinstance(kept, QuestionRow)
    assert any(ratio(each) < 1 for each in kept.legibility)


def test_a_legible_question_is_kept() -> None:
    (row,) = ask(Design(task_from(SCENE.format(body=GLIDE.format(speed=12, other=6, color="blue")))), 0, pair())
    assert isinstance(row, QuestionRow), row
    assert all(ratio(each) >= 1 for each in row.legibility)
