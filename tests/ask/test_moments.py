"""Measures at a time, against mechanics, in every engine: free fall, sliding, a swing about a hinge, a rail."""

from __future__ import annotations

import math
from functools import cache

import pytest

from tests.ask.asking import pair
from tests.engines import ENGINES
from tests.language.specs import task_from
from wmspec.compile.design.design import Design
from wmspec.lang.check.ir.evaluate import evaluate
from wmspec.runtime.questions.question_context import QuestionContext
from wmspec.runtime.questions.runs import execute

G = 9.81
#: A rod of 30 cm, fixed at one end, falls from level; the questions are about plain quantities, so nothing is drawn.
SPEC = """
use floor
task moments : custom {
  factor n in [2, 3]
  object ball { shape: sphere  size: 10 cm  at: (1 m, 1 m, 2 m) }
  object thrown { shape: sphere  size: 10 cm  at: (1 m, -1 m, 1 m) }
  object slab { shape: box  size: (20 cm, 20 cm, 4 cm)  friction: 0.5  on: floor }
  object beam { shape: box  size: (30 cm, 2 cm, 2 cm)  mass: 1 kg  at: (-85 cm, 0, 2 m) }
  joint hinge_1 : hinge { of: beam  at: (-1 m, 0, 2 m)  axis: (0, 1, 0) }
  object lift { shape: cube  size: 6 cm  at: (0, 2 m, 3 m) }
  joint rail : slider { of: lift  at: (0, 2 m, 3 m)  axis: (0, 0, 1) }
  objects posts[n] { shape: cube  size: 10 cm  on: floor at (-2 m + index * 20 cm, -2 m) }

  action shove = launch(slab, direction: 90 deg, speed: 2 m/s) at 0 s
  action throw = launch(thrown, direction: 180 deg, climb: 60 deg, speed: 2 m/s) at 0 s
  horizon 0.75 s
  camera eye { at: (0, -3 m, 1 m) }
  observe eye at [0 s, end]
QUESTIONS
}
"""


def rod(time: float, length: float = 0.3, width: float = 0.02, step: float = 1e-4) -> float:
    """How far (rad) a rod that was let go level has swung: Runge and Kutta's solution of I a'' = m g l/2 cos(a)."""
    about = (length**2 + width**2) / 12 + (length / 2) ** 2

    def force(angle: float) -> float:
        return G * length / 2 * math.cos(angle) / about

    angle = rate = 0.0
    for _ in range(round(time / step)):
        k1, l1 = rate, force(angle)
        k2, l2 = rate + step / 2 * l1, force(angle + step / 2 * k1)
        k3, l3 = rate + step / 2 * l2, force(angle + step / 2 * k2)
        k4, l4 = rate + step * l3, force(angle + step * k3)
        angle += step / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
        rate += step / 6 * (l1 + 2 * l2 + 2 * l3 + l4)
    return angle


UP = 2 * math.sin(math.radians(60))
#: What is asked, what mechanics answers, and how far an engine may be off, in SI units.
ORACLES = {
    "height(ball, at: 0.5 s)": (2 - G * 0.5**2 / 2, 1e-3),
    "position(ball, at: 0.25 s).z": (2 - G * 0.25**2 / 2, 1e-3),
    "displacement(ball, at: 0.25 s)": (G * 0.25**2 / 2, 1e-3),
    "distance(ball, thrown, at: 0 s)": (math.sqrt(5), 1e-6),
    "speed(ball, at: 0.25 s)": (G * 0.25, 5e-3),
    "speed(ball, from: 0.25 s, to: 0.5 s)": (G * 0.375, 5e-3),
    "highest(thrown)": (1 + UP**2 / 2 / G, 1e-3),
    "when_highest(thrown)": (UP / G, 2.5 / 240),
    "heading(thrown, at: 0.1 s) - 180 deg": (0.0, 1e-3),
    "contact_time(thrown, floor)": ((UP + math.sqrt(UP**2 + 2 * G * 0.95)) / G, 2 / 240),
    "position(slab, at: 0.25 s).y": (2 * 0.25 - 0.5 * G * 0.25**2 / 2, 3e-3),
    "speed(slab, at: 0.25 s)": (2 - 0.5 * G * 0.25, 1e-2),
    "angle(hinge_1, at: 0.25 s)": (rod(0.25), 5e-3),
    "angle(hinge_1)": (rod(0.75), 2e-2),
    "extension(rail, at: 0.5 s)": (-G * 0.5**2 / 2, 2e-3),
    "sum(height(posts))": (0.15, 1e-3),
    "max(position(ball, at: 0.25 s).z, height(thrown, at: 0 s))": (2 - G * 0.25**2 / 2, 1e-3),
}
SAID = {
    "moved(ball, from: 0 s, to: 0.1 s)": True,
    "moved(posts[-1])": False,
    "contact(thrown, floor, to: 0.3 s)": False,
    "at_rest(slab, at: 0.1 s)": False,
    "at_rest(slab)": True,
    "any(moved(posts, to: 0.7 s))": False,
    "all(at_rest(posts, at: 0.6 s))": True,
    "count(height(posts) < 6 cm) == n": True,
    "contact_time(slab, floor) < contact_time(thrown, floor)": True,
}


@cache
def answers(engine: str) -> dict[str, object]:
    """What is measured in an engine of every question."""
    probed = [*ORACLES, *SAID]
    lines = [f'  question "?" {{ answer {a} }}' for a in SAID]
    lines = [f'  question "?" {{ answer {a}  within {_unit(a)} }}' for a in ORACLES] + lines
    design = Design(task_from(SPEC.replace("QUESTIONS", "\n".join(lines))))
    engines = pair(engine)
    run = execute(design, design[1], None, engines)
    found = {}
    for text, question in zip(probed, design.spec.questions, strict=True):
        asking = QuestionContext(question, run, engines)
        found[text] = evaluate(question.answer, asking.measured)
    return found


def _unit(answer: str) -> str:
    for word, unit in (("speed", "1 m/s"), ("when", "1 s"), ("time", "1 s"), ("heading", "1 deg"), ("angle", "1 deg")):
        if answer.startswith((word, f"contact_{word}")):
            return unit
    return "1 m"


@pytest.mark.engine
@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("answer", ORACLES)
def test_measures_equal_mechanics(answer: str, engine: str) -> None:
    expected, off = ORACLES[answer]
    assert answers(engine)[answer] == pytest.approx(expected, abs=off)


@pytest.mark.engine
@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("answer", SAID)
def test_events_are_equal_in_every_engine(answer: str, engine: str) -> None:
    assert answers(engine)[answer] is SAID[answer]
