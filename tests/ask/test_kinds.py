"""The kinds of questions are one table, and nothing outside their modules asks which kind a question is."""

from __future__ import annotations

import re
from pathlib import Path
from typing import get_args

import pytest

import wmspec
from tests.ask.asking import ask_all, one, pair, refused, spec_of
from wmspec.compile.design.design import Design
from wmspec.compile.stage.episode import document
from wmspec.compile.stage.layers import compose
from wmspec.lang.check.ir.ir import QuestionKind
from wmspec.lang.check.statements.question_kinds import QUESTION_RULES
from wmspec.runtime.caches.trace_cache import TraceCache
from wmspec.runtime.compare.check import check
from wmspec.runtime.compare.tolerance import Tolerances
from wmspec.runtime.questions.ask import ask
from wmspec.runtime.questions.consensus import consensus
from wmspec.runtime.questions.kinds import KINDS
from wmspec.runtime.questions.model import TRUTH, QuestionRow
from wmspec.sim.usd import read

SOURCES = Path(wmspec.__file__).parent
#: Where a kind may be named: in its own module, where kinds are distinguished, and in the type that names them all.
KNOWING = ("runtime/questions/kinds/", "lang/check/statements/question_kinds.py", "lang/check/ir/ir.py")


def test_the_language_and_the_questions_know_the_same_kinds() -> None:
    assert set(KINDS) == set(QUESTION_RULES) == set(get_args(QuestionKind))


def test_no_other_module_asks_which_kind_a_question_is() -> None:
    names = "|".join((*KINDS, "picture"))
    asks = re.compile(rf"""\b(kind|sort)\b\s*(==|!=|in|not in)\s*[(\[{{]?\s*["']({names})["']""")
    for path in sorted(SOURCES.rglob("*.py")):
        name = path.relative_to(SOURCES).as_posix()
        assert name.startswith(KNOWING) or not asks.search(path.read_text()), name


QUESTIONS = """
  factor pace in [20, 10] cm/s
  object ball { shape: sphere  size: 8 cm  color: red   on: table at (-20 cm, 10 cm) }
  object dice { shape: cube    size: 8 cm  color: blue  on: table at (-20 cm, -10 cm) }
  action a = glide(ball, direction: 0 deg, speed: pace) for 0.5 s
  action b = glide(dice, direction: 0 deg, speed: 5 cm/s) for 0.5 s
  observe front at [0 s, 0.5 s]
  question "Which is faster?" { options [ball, dice]  answer fastest([ball, dice]) }
  question "Does it move?"    { answer moved(ball) }
  question "How far?"         { answer displacement(ball)  within 1 cm }
  question "What next?"       { answer frame(front, end)  counterfactual slow { action a.speed: 1 cm/s } }
"""


def test_kind_follows_from_answer_and_clauses() -> None:
    questions = ask_all(QUESTIONS)
    assert [q.kind for q in questions if isinstance(q, QuestionRow)] == ["labels", "labels", "numbers", "pictures"]
    assert [q.answer is None for q in questions if isinstance(q, QuestionRow)] == [False, False, True, False]


LOOKS = """
  factor which in [0, 1, 2, 3]
  object ball { shape: sphere  size: 8 cm  color: red  on: table at (-20 cm + which * 1 cm, 0) }
  action go = launch(ball, direction: 0 deg, speed: 30 cm/s, rolling: true)
  horizon 0.8 s
  observe front at [0 s, 0.2 s]
  question "What comes next?" {
    answer frame(front, end)
    counterfactual other { state %s }
    counterfactual slow  { action go.speed: 10 cm/s }
    %s
  }
"""
DARKER = "sun.ambient: 0.2"


@pytest.mark.parametrize("change", ["ball.color: blue", "front.at: (10 cm, -105 cm, 92 cm)"])
def test_look_distractors_appear_at_any_place_of_the_truth(change: str) -> None:
    """In a dataset of several engines, and in a crosscheck."""
    design = Design(spec_of(LOOKS % (change, "distinct by 5 cm")))
    slots = set()
    for index in range(len(design)):
        answers = {engine: ask(design, index, pair(engine))[0] for engine in ("mujoco", "pybullet")}
        for row in consensus(answers, "all").values():
            assert isinstance(row, QuestionRow), row
            assert row.answer is not None
            assert row.options[row.answer].name == TRUTH
            assert {vote.answer for vote in row.agreement} == {row.answer}
            slots.add(row.answer)
    assert slots == {0, 1, 2}
    engines = [TraceCache("mujoco"), TraceCache("pybullet")]
    (verdict,) = check(design, 0, engines, Tolerances()).verdicts
    assert verdict.agree
    assert verdict.is_accepted


def test_options_in_the_same_place_that_look_the_same_are_too_near() -> None:
    heavier = LOOKS % ("ball.density: 3000 kg/m^3", "distinct by 5 cm")
    assert refused(heavier).startswith("alike: truth and other: 0.0 cm apart")


def test_another_light_is_another_look() -> None:
    row = one(LOOKS % (DARKER, ""))
    assert {option.name for option in row.options} == {TRUTH, "other", "slow"}


def test_texts_among_options_say_values() -> None:
    body = """
      factor tone in [red, blue]
      object ball { shape: sphere  size: 8 cm  color: tone  called: "marble"  on: table at (-20 cm, 10 cm) }
      object dice { shape: cube    size: 8 cm  color: green  on: table at (20 cm, -10 cm) }
      observe front at [0 s]
      question "Where is {ball}, {dice.size} from nothing?" {
        options ["left of {dice}", "{tone} and \\{right\\}"]
        answer  if position(ball).x < 0 then "left of {dice}" else "{tone} and \\{right\\}"
      }"""
    (question,) = ask_all(body)
    assert isinstance(question, QuestionRow)
    assert question.text == "Where is the red marble, 8 cm from nothing?"
    assert {option.text for option in question.options} == {"left of the green cube", "red and {right}"}
    assert question.options[question.answer or 0].text == "left of the green cube"


def test_lights_have_the_intensity_of_the_spec() -> None:
    """Also if sun and sky do not sum to 1."""
    task = spec_of(LOOKS % (DARKER, ""))
    (question,) = task.questions
    drawn = Design(task)[0]
    lights = [read(compose(document(task, drawn, change))).light for change in (None, question.counterfactuals[0])]
    assert [round(light.ambient, 3) for light in lights] == [0.6, 0.2]
    assert lights[0].diffuse == lights[1].diffuse
