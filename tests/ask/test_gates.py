"""What is not asked, and why: too close to call, overlapping, chaotic, diverging, alike."""

from __future__ import annotations

import pytest

from tests.ask.asking import ask_all, one, refused
from wmspec.runtime.questions.model import QuestionRow

RACE = """
  factor pace in [{paces}] cm/s
  object far  { shape: sphere  size: 8 cm  color: red   on: table at (-20 cm, 12 cm) }
  object near { shape: cube    size: 8 cm  color: blue  on: table at (-20 cm, -12 cm) }
  action a = glide(far, direction: 0 deg, speed: pace) for 0.5 s
  action b = glide(near, direction: 0 deg, speed: 10 cm/s) for 0.5 s
  observe front at [0 s, 0.5 s]
"""
FASTER = """question "Which is faster?" {
  options [far, near, neither]  answer fastest([far, near], tie: 1.05)
  margin speed(far) / speed(near) apart by 1.2 unless fastest([far, near], tie: 1.05) == neither
  difference speed(far) / speed(near)
}"""


@pytest.mark.parametrize(("pace", "said"), [("20", "the red sphere"), ("5", "the blue cube"), ("10.2", "neither")])
def test_a_tie_is_an_answer_and_needs_no_margin(pace: str, said: str) -> None:
    question = one(RACE.replace("{paces}", pace) + FASTER)
    assert question.value == said
    assert sorted(o.text or "" for o in question.options) == ["neither", "the blue cube", "the red sphere"]
    assert question.options[question.answer or 0].text == said
    assert (question.margin is None) == (said == "neither")
    assert question.difference is not None
    assert question.difference.quantity == "speed(far) / speed(near)"
    assert question.difference.value == pytest.approx(float(pace) / 10, rel=1e-3)


def test_leads_between_tie_and_margin_are_rejected() -> None:
    assert refused(RACE.replace("{paces}", "11") + FASTER).startswith("margin: 1.1 where 1.2")


def test_open_numbers_and_named_questions_and_truths() -> None:
    questions = ask_all(
        RACE.replace("{paces}", "20")
        + 'question far "How far does the sphere go?" { answer displacement(far)  within 2 cm }'
        + 'question "Does the cube move?" { answer moved(near) }'
        + 'question "How fast is the cube?" { answer speed(near)  options [5 cm/s, 10 cm/s, 20 cm/s] }'
    )
    far, moves, fast = (q for q in questions if isinstance(q, QuestionRow))
    assert far.name == "far"
    assert (far.answer, far.options, far.value) == (None, (), "10 cm")
    assert far.number is not None
    assert (far.number.unit, far.number.within) == ("m", 0.02)
    assert far.number.value == pytest.approx(0.1)
    assert moves.value == "yes"
    assert {o.text for o in moves.options} == {"yes", "no"}
    assert fast.value == "10 cm/s"
    assert fast.options[fast.answer or 0].name == "0.1"


def test_bodies_inside_one_another_are_refused() -> None:
    body = """object a { size: 8 cm  on: table at (0, 0) } object b { size: 8 cm  color: red  on: table at (%s cm, 0) }
      observe front at [0 s]  question "Large?" { options [a, b]  answer largest([a, b]) }"""
    assert refused(body % "7.8") == "overlap: a and b are 2.0 mm deep in each other at the start"
    assert one(body % "7.95").options  # half a millimetre is touching


BALANCE = """
  object post { shape: cone  radius: 3 cm  height: 10 cm  color: black  on: table at (0, 0)  fixed: true }
  object ball { shape: sphere  size: 8 cm  color: red  at: (%s, 0, 14 cm) }
  observe front at [0 s, 0.8 s]
  question "Where does the ball end, seen from the post?" { %s
    options [left_of, right_of, in_front_of, behind, above]  answer relation(ball, post) }
"""


def test_a_ball_on_the_tip_of_a_post_has_no_answer() -> None:
    assert refused(BALANCE % ("0", "stable by 1 mm"), engine="mujoco").startswith("unstable: ")


def test_ball_beside_the_tip_keeps_its_question() -> None:
    (question,) = ask_all(BALANCE % ("12 mm", "stable by 1 mm"), engine="mujoco")
    assert isinstance(question, QuestionRow), question
    assert question.value == "to the right of it"


def test_without_a_word_a_small_nudge_is_tried_where_something_free_moves() -> None:
    nudged = refused(BALANCE % ("0.1 mm", ""), engine="mujoco")
    assert nudged.startswith("unstable")
    assert "0.5 mm" in nudged


NEXT = """
  object ball { shape: sphere  size: 8 cm  color: red   on: table at (-25 cm, 0) }
  object post { shape: cube  size: 8 cm  color: blue  on: table at (5 cm, %s) }
  action go = launch(ball, direction: 0 deg, speed: 60 cm/s, rolling: true) at 0.1 s
  action stop = teleport(mark, to: (20 cm, -20 cm)) at 0.5 s
  object mark { shape: cone  size: 6 cm  color: yellow  on: table at (-20 cm, -20 cm) }
  horizon 1 s
  observe front at [0 s, 0.2 s]
  question "Next?" { answer frame(front, end)  %s }
"""


def test_an_option_without_an_object() -> None:
    changes = "counterfactual gone { state post.present: false }  counterfactual slow { action go.speed: 1 cm/s }"
    question = one(NEXT % ("0", changes))
    options = {o.name: o for o in question.options}
    assert options["truth"].kind == "truth"
    change = options["gone"].change
    assert change is not None
    assert (change.target, change.before, change.after) == ("post.present", "yes", "no")
    assert question.options[question.answer or 0].name == "truth"


ORDER = """
  object ball { shape: sphere  size: 8 cm  color: red   on: table at (-20 cm, 10 cm) }
  object block { shape: cube  size: 8 cm  color: blue  on: table at (-20 cm, -10 cm) }
  action first = glide(ball, direction: 0 deg, speed: 30 cm/s) for 0.5 s
  action second = glide(block, direction: 0 deg, speed: 30 cm/s) for 0.5 s after first
  observe front at [0 s]
  horizon 1 s
  question "Which shows the middle?" { answer frame(front, 0.5 s)  counterfactual swapped { order first, second } }
"""


def test_an_option_in_another_order() -> None:
    swapped = next(o for o in one(ORDER).options if o.name == "swapped").change
    assert swapped is not None
    assert (swapped.kind, swapped.before, swapped.after) == ("order", "first first", "second first")


def test_an_option_that_changes_nothing_that_can_be_seen_is_alike() -> None:
    body = NEXT % ("25 cm", "counterfactual heavy { state post.density: 1200 kg/m^3 }")
    assert refused(body).startswith("alike: truth and heavy")


def test_no_picture_after_the_end() -> None:
    late = NEXT.replace("end)", "onset(ball) + 3 s)") % ("25 cm", "counterfactual slow { action go.speed: 1 cm/s }")
    assert refused(late).startswith("invalid: 3.1")
    assert "is outside the episode, which lasts 1 s" in refused(late)
    shorter = NEXT.replace("horizon 1 s", "horizon if go.speed > 0.5 m/s then 1 s else 0.5 s") % (
        "25 cm",
        "counterfactual slow { action go.speed: 10 cm/s }",
    )
    assert refused(shorter) == "invalid: slow: 1 s is outside the episode, which lasts 0.5 s"


@pytest.mark.parametrize(
    ("camera", "said"), [("front", "to the left of it"), ("side", "behind it"), ("other", "to the right of it")]
)
def test_relations_are_those_of_the_pictures(camera: str, said: str) -> None:
    question = one(f"""
      object a {{ shape: sphere  size: 8 cm  color: red   on: table at (-20 cm, 0) }}
      object b {{ shape: cube    size: 8 cm  color: blue  on: table at (0, 0) }}
      camera other {{ at: (0, 105 cm, 92 cm)  look_at: (0, 3 cm, 0) }}
      observe {camera} at [0 s]
      question "Where?" {{ answer relation(a, b)  options [left_of, right_of, in_front_of, behind] }}""")
    assert question.value == said


def test_a_color_can_be_an_option() -> None:
    question = one(NEXT % ("25 cm", "counterfactual other { state post.color: yellow }"))
    assert {o.name for o in question.options} == {"truth", "other"}


def test_a_divergence_that_mujoco_would_hide_is_counted() -> None:
    """MuJoCo resets a state that is not finite and goes on; the episode would look as if nothing had happened."""
    body = """object ball { shape: sphere  size: 8 cm  mass: 1 mg  on: table at (0, 0) }
      action hit = force(ball, direction: 0 deg, force: 1000000000000000000000 N) for 0.5 s at 0.1 s
      observe front at [0 s, 0.5 s]  question "Moves?" { answer moved(ball) }"""
    assert refused(body, engine="mujoco").startswith("unstable: ")
