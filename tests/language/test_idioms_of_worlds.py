"""A task's own world beside a library's, and what a camera sees of what falls."""

from __future__ import annotations

import pytest

import wmspec
from tests.language.specs import task_from
from wmspec.compile.layout.evaluator import Evaluator
from wmspec.core.diagnostics import SpecError

WORLD = """use room
task t : custom {{
  {world}
  object ball {{ shape: sphere  size: 10 cm  at: (0, 0, 1 m) }}
  observe front at [0 s]
  question "?" {{ answer height(ball) > 5 cm }}
}}
"""


def test_a_task_may_set_the_gravity_of_a_room() -> None:
    spec = task_from(WORLD.format(world="world { gravity: 1.6 m/s^2 }"))
    values = Evaluator(spec, {})
    assert values.gravity == pytest.approx(1.6)
    assert values.property("world", "background") == "mist", "the rest is the room's"


def test_task_may_override_the_room() -> None:
    values = Evaluator(task_from(WORLD.format(world="world { background: slate }")), {})
    assert values.property("world", "background") == "slate"


def test_two_worlds_of_a_task_are_a_mistake() -> None:
    with pytest.raises(SpecError) as raised:
        task_from(WORLD.format(world="world { gravity: 0 }  world { gravity: 1 m/s^2 }"))
    assert raised.value.diagnostics[0].code == "WMS202"


def test_a_camera_at_the_ground_sees_what_falls_there() -> None:
    spec = """object ground { shape: box  size: (4 m, 4 m, 10 cm)  at: (0, 0, -5 cm)  fixed: true }
    camera low { at: (0, -1 m, 20 cm)  look_at: (0, 0, 10 cm) }
    task t : custom {
      object ball { shape: sphere  size: 10 cm  at: (0, 0, HIGH)  FIXED }
      observe low at [0.8 s]
      question "Does it bounce?" { answer highest(ball, from: 0.6 s, to: 0.8 s) > 10 cm }
    }"""
    for fixed, codes in (("", set()), ("fixed: true", {"WMS602"})):
        found = wmspec.diagnose(text=spec.replace("HIGH", "2 m").replace("FIXED", fixed))
        assert {each.code for each in found.diagnostics if each.code == "WMS602"} == codes


TASK = """use tabletop
task t : custom {{
  factor tone in [red, blue]
  factor heavy in [100 g, 2 kg]
  let shown = ball.color
  object ball {{ shape: sphere  size: 10 cm  color: tone  mass: heavy  {more}  on: table at (-10 cm, 0) }}
  object cube_a {{ shape: cube  size: 10 cm  mass: 1 kg  color: green  on: table at (10 cm, 0) }}
  observe front at [{times}]
  question "{text}" {{ answer {answer} {options} }}
}}
"""
COLORS = "options [red, blue]"


def codes(**written: str) -> set[str]:
    """The diagnostics of a task with these words."""
    given = {"more": "", "times": "0 s", "text": "?", "options": ""} | written
    return {found.code for found in wmspec.diagnose(text=TASK.format(**given)).diagnostics}


@pytest.mark.parametrize("answer", ["tone", "ball.color", "shown"])
@pytest.mark.parametrize("said", ["tone", "ball.color", "shown"])
def test_text_with_the_answer_in_another_spelling(answer: str, said: str) -> None:
    assert "WMS510" in codes(text=f"Is the {{{said}}} ball red?", answer=answer, options=COLORS)
    assert "WMS510" not in codes(text="Which colour has the ball?", answer=answer, options=COLORS)


def test_a_mass_is_not_to_be_seen_in_one_picture() -> None:
    heavier = "ball.mass > cube_a.mass"
    assert "WMS605" in codes(text="Is the ball heavier than the cube?", answer=heavier)
    assert "WMS605" not in codes(text="Is the ball heavier than the cube?", answer=heavier, times="0 s, 1 s")
    shown = "material: if heavy > 1 kg then metal else wood"
    assert "WMS605" not in codes(text="Is the ball heavier than the cube?", answer=heavier, more=shown)
