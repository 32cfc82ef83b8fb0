"""What-ifs and causes: measured on the changed episode, with gates and agreement on both."""

from typing import Any

import pytest

from tests.ask.asking import one, pair
from tests.engines import ENGINES
from tests.language.specs import task_from
from wmspec.compile.design.depend import Dependencies
from wmspec.compile.design.design import Design
from wmspec.compile.design.what_ifs import possible_what_ifs, what_ifs
from wmspec.compile.layout.evaluator import Evaluator
from wmspec.compile.stage.episode import document
from wmspec.dataset.build.rows import encode, schema
from wmspec.runtime.questions.ask import ask
from wmspec.runtime.questions.cross_validation import CrossValidation
from wmspec.runtime.questions.model import QuestionRow, Rejected

FELLED = """use room
task felled : custom {
  factor heavy in ["red", "blue", "both", "none"]
  object tower  { shape: box     size: (8 cm, 8 cm, 30 cm)  color: oak  mass: 1 kg  on: floor at (0, 0) }
  let mass_a = if heavy == "red" or heavy == "both" then 1 kg else 20 g
  let mass_b = if heavy == "blue" or heavy == "both" then 1 kg else 20 g
  object ball_a { shape: sphere  size: 12 cm  color: red   mass: mass_a  on: floor at (-50 cm, 0) }
  object ball_b { shape: sphere  size: 12 cm  color: blue  mass: mass_b  on: floor at (50 cm, 0) }
  action roll_a = launch(ball_a, direction: right, speed: 1.2 m/s, rolling: true) at 0.1 s
  action roll_b = launch(ball_b, direction: toward(tower), speed: 1.2 m/s, rolling: true) at 0.3 s
  horizon 2 s
  observe front at [0 s, 0.3 s, 1 s]
  QUESTIONS
}"""


def first_questions(question: str, *levels: str, engine: str = "mujoco") -> dict[str, QuestionRow | Rejected]:
    """The only question of the instances that have these levels of the factor, by the level."""
    design = Design(task_from(FELLED.replace("QUESTIONS", f'question "?" {{ {question} }}')))
    heavy = {str(design[i].factors["heavy"]): i for i in range(len(design))}
    return {level: ask(design, heavy[level], pair(engine))[0] for level in levels}


def values(rows: dict[str, QuestionRow | Rejected]) -> dict[str, tuple[str, Any]]:
    return {
        heavy: (row.value, row.actual) if isinstance(row, QuestionRow) else (row.reason, None)
        for heavy, row in rows.items()
    }


@pytest.mark.parametrize("engine", ENGINES)
def test_the_answer_is_that_of_the_changed_episode(engine: str) -> None:
    answer = "answer toppled(tower) without ball_a  legibility off"
    found = values(first_questions(answer, "red", "blue", "none", engine=engine))
    assert found["red"] == ("no", "yes")
    assert found["blue"] == ("yes", "yes")
    assert found["none"] == ("no", "no")


def test_omitted_action_keeps_its_objects_in_the_picture() -> None:
    found = values(first_questions("answer toppled(tower) without roll_a", "red"))
    assert found["red"] == ("no", "yes")


def test_a_level_and_an_argument() -> None:
    found = values(first_questions("answer toppled(tower) under action roll_a.speed: 0.2 m/s", "red"))
    assert found["red"] == ("no", "yes")
    found = values(first_questions('answer toppled(tower) under heavy: "none"', "red", "none"))
    assert found["red"] == ("no", "yes")
    assert found["none"] == ("unchanged", None)


def test_numbers_and_what_they_would_actually_be() -> None:
    row = first_questions("answer displacement(ball_b) without ball_a  within 5 cm  legibility off", "red")["red"]
    assert isinstance(row, QuestionRow)
    assert row.number is not None
    assert row.actual is not None
    assert row.actual != row.value
    assert [(change.kind, change.target) for change in row.what_ifs or ()] == [("without", "ball_a")]


def test_the_picture_of_a_what_if_stands_beside_what_happens() -> None:
    row = first_questions(
        "answer frame(front, end) without ball_a  counterfactual still { without roll_b }  distinct by 3 cm", "red"
    )
    kept = row["red"]
    assert isinstance(kept, QuestionRow)
    assert sorted((option.kind, option.name) for option in kept.options) == [
        ("actual", "actual"), ("counterfactual", "still"), ("truth", "truth"),
    ]  # fmt: skip


def test_one_cause_is_the_answer_and_none_or_several_are_a_reason() -> None:
    found = first_questions(
        "options [ball_a, ball_b]  answer cause of toppled(tower) among [ball_a, ball_b]  legibility off", "red", "none"
    )
    kept = found["red"]
    assert isinstance(kept, QuestionRow)
    assert kept.value == "the red sphere"
    none = found["none"]
    assert isinstance(none, Rejected)
    assert (none.reason, none.detail) == ("cause", "it does not happen, so nothing is its cause")
    spared = first_questions(
        "options [ball_b, tower]  answer cause of toppled(tower) among [ball_b]  legibility off", "red"
    )["red"]
    assert isinstance(spared, Rejected)
    assert spared.detail == "it happens without any of ball_b, so no single one is its cause"


def test_a_condition_that_needs_two_actions_has_no_single_cause() -> None:
    moved = "displacement(ball_a) > 10 cm and displacement(ball_b) > 10 cm"
    cause = f"(cause of {moved} among [roll_a, roll_b]) == roll_a"
    both = first_questions(
        f'options ["one", "other"]  answer if {cause} then "one" else "other"  legibility off', "red"
    )["red"]
    assert isinstance(both, Rejected)
    assert (both.reason, both.detail) == ("cause", "it needs roll_a and roll_b, so no single one is its cause")


def test_engines_agree_on_both_episodes() -> None:
    """A row is kept if the engines give the same answer with the change, and the same without it."""
    text = FELLED.replace("QUESTIONS", 'question "?" { answer toppled(tower) without ball_a  legibility off }')
    design = Design(task_from(text))
    pairs = {engine: pair(engine) for engine in ENGINES}
    for index in range(len(design)):
        (row,) = CrossValidation(design, index, pairs, "all").questions()
        assert isinstance(row, QuestionRow), row


def test_bodies_that_move_in_the_what_if_alone_are_nudged() -> None:
    """In the episode as it is nothing moves; without its support the block falls, on either side of a line."""
    spec = task_from("""use tabletop
      task one : custom {
        factor tone in [red, blue, yellow, orange, pink]
        object prop  { shape: cube  size: 8 cm  color: tone   on: table at (0, 0) }
        object block { shape: box   size: (10 cm, 10 cm, 4 cm)  color: green  on: prop at (0.1 mm, 0) }
        observe front at [0 s]  horizon 1 s
        question "Where?" { answer (height(block) < 5 cm and position(block).x > 0) without prop  legibility off } }""")
    design = Design(spec)
    rows = [ask(design, i, pair("mujoco"))[0] for i in range(len(design))]
    reasons = {row.detail for row in rows if isinstance(row, Rejected) and row.reason == "unstable"}
    assert reasons == {"True becomes False when free bodies are displaced by 0.5 mm"}


def test_omitting_an_object_changes_nothing_else() -> None:
    """Values that count or place by the object keep theirs."""
    spec = task_from("""use tabletop
      task one : custom {
        factor n in [2, 3]
        objects cubes[n] { shape: cube  size: 4 cm  color: red  on: table  scatter: (40 cm, 20 cm) }
        let many = count(cubes)
        object post { shape: cube  size: 2 cm * many  color: blue  on: table at (30 cm, 0) }
        object hat  { shape: cube  size: 3 cm  color: green  on: cubes[0] at (0, 0) }
        observe front at [0 s]  horizon 1 s
        question "Is it low?" { answer height(hat) < 4 cm without cubes[0] } }""")
    design = Design(spec)
    instance = design[1]
    truth = Evaluator(spec, instance.values, None, instance.key)
    (change,) = what_ifs(spec.questions[0], truth)
    differing = document(spec, instance).differing(document(spec, instance, change))
    assert {path.split("/")[3] for path in differing if path.count("/") > 2} == {"cubes_0"}


def test_possible_what_ifs_include_those_of_every_instance() -> None:
    spec = task_from("""use tabletop
      task one : custom {
        factor which in [a, b]
        object a { shape: cube  size: 4 cm  color: red  on: table at (0, 0) }
        object b { shape: cube  size: 4 cm  color: blue  on: table at (20 cm, 0) }
        object c { shape: cube  size: 4 cm  color: green  on: a at (0, 0) }
        observe front at [0 s]  horizon 1 s
        question "Is it low?" { answer height(c) < 4 cm without which } }""")
    names = [change.name for change in possible_what_ifs(spec.questions[0], Dependencies(spec))]
    assert names == ["without_a", "without_b"]


def test_changes_of_other_words_have_other_names() -> None:
    spec = task_from("""use tabletop
      task one : custom {
        factor n in [2, 3]
        objects cubes[n] { shape: cube  size: 4 cm  color: red  on: table at (10 cm * index, 0) }
        object c { shape: cube  size: 4 cm  color: green  on: cubes[0] at (0, 0) }
        action go = launch(c, direction: 10 deg, speed: 0.1 m/s)
        observe front at [0 s]  horizon 1 s
        question "Is it low?" { answer height(c) < 4 cm without cubes[1] }
        question "Is it low?" { answer height(c) < 4 cm without cubes[-1] }
        question "Is it low?" { answer height(c) < 4 cm under action go.direction: go.direction + 5 deg }
        question "Is it low?" { answer height(c) < 4 cm under action go.direction: go.direction - 5 deg } }""")
    design = Design(spec)
    truths = [Evaluator(spec, design[i].values, None, design[i].key) for i in range(len(design))]
    removed = {(change.owner, i) for i, truth in enumerate(truths) for change in what_ifs(spec.questions[1], truth)}
    assert {owner for owner, _ in removed} == {"cubes_1", "cubes_2"}
    plus, minus = (what_ifs(spec.questions[q], truths[0])[0].name for q in (2, 3))
    assert plus != minus


def test_rows_of_a_task_with_a_what_if_have_the_same_columns() -> None:
    spec = task_from("""use tabletop
      task one : custom {
        factor tone in [red, blue]
        object a { shape: cube  size: 6 cm  color: tone   on: table at (0, 0) }
        object b { shape: cube  size: 6 cm  color: green  on: a at (0, 0) }
        observe front at [0 s]  horizon 1 s
        question "Would it be low?" { answer height(b) < 4 cm without a  legibility off }
        question "Is it low?" { answer height(b) < 4 cm  legibility off } }""")
    rows = ask(Design(spec), 0, pair("mujoco"))
    made = [encode(row, "questions") for row in rows if isinstance(row, QuestionRow)]
    assert [row["what_if"] for row in made] == [["without a"], []]
    assert [row["actual_value"] for row in made] == ["no", None]
    assert all(row.keys() == set(schema(spec).names) for row in made)


@pytest.mark.parametrize(
    ("change", "shown", "moments"),
    [("", "1 s", 3), ("", "0.4 s", 2), (" without blocker", "1 s", 2), (" without go", "1 s", 2)],
)
def test_unseen_course_is_predicted_from_two_moments(change: str, shown: str, moments: int) -> None:
    body = f"""
      factor tone in [red, blue]
      object ball {{ shape: sphere  size: 8 cm  color: tone  on: table at (-20 cm, 0) }}
      object blocker {{ shape: cube  size: 8 cm  color: green  on: table at (10 cm, 0) }}
      object wall {{ shape: cube  size: 8 cm  color: oak  on: table at (24 cm, 0)  fixed: true }}
      action go = launch(ball, direction: right, speed: 60 cm/s, rolling: true)
      horizon 1 s
      observe front at 0 s .. {shown} in 3 frames
      question "Does it meet the wall?" {{ answer contact(ball, wall){change}  may hide [ball, blocker, wall] }}
    """
    assert one(body, engine="mujoco").moments == moments
