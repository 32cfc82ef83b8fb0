"""`answer possible`: an episode is impossible if an action that breaks the laws of physics changes it, and shows."""

from __future__ import annotations

import pytest

from tests.ask.asking import ask_all, pair, quick_matrix, refused, spec_of
from tests.engines import ENGINES
from tests.language.specs import task_from
from wmspec.compile.design.design import Design
from wmspec.core.diagnostics import SpecError
from wmspec.dataset.build.rows import encode
from wmspec.lang.check.statements.possibility import VIOLATIONS
from wmspec.runtime.questions.closed_sets import ask_complete, has_closed_set
from wmspec.runtime.questions.cross_validation import CrossValidation
from wmspec.runtime.questions.model import QuestionRow, Rejected

ROLL = """
  object ball {{ shape: sphere  size: 8 cm  color: red  on: table at (-25 cm, 0) }}
  object wall {{ shape: box  size: (2 cm, 14 cm, 12 cm)  color: blue  on: table at (10 cm, 0)  fixed: true }}
  action push = launch(ball, direction: right, speed: {pace}, rolling: true) at 0.1 s
  action odd = {odd}
  horizon 1 s
  observe front at [0 s, 0.2 s, 0.9 s]
  question "Is this possible?" {{ answer possible  may hide ball }}
"""
FAST = "50 cm/s"


def possibility(odd: str, engine: str = "pybullet", pace: str = FAST) -> QuestionRow:
    (found,) = ask_all(ROLL.format(odd=odd, pace=pace), engine=engine)
    assert isinstance(found, QuestionRow), found
    return found


ODD = [
    ("paint(ball, color: red) at 0.5 s", "possible"),
    ("paint(ball, color: green) at 0.5 s", "impossible"),
    ("vanish(ball) at 0.5 s", "impossible"),
    ("stop(ball) at 0.3 s", "impossible"),
    ("stop(ball) at 0.05 s", "possible"),
    ("teleport(ball, to: (0, 5 cm)) at 0.5 s", "impossible"),
    ("teleport(ball, to: (-25 cm, 0)) at 0.05 s", "possible"),
    ("pass_through(ball, wall) for 0.9 s", "impossible"),
    ("pass_through(ball, wall) for 0.2 s", "possible"),
]


@pytest.mark.parametrize(("odd", "value", "engine"), quick_matrix(ODD, "pybullet", 3))
def test_altered_film_is_impossible(odd: str, value: str, engine: str) -> None:
    row = possibility(odd, engine)
    assert row.value == value
    assert [option.text for option in row.options if option.kind == "truth"] == [value]
    assert {option.text for option in row.options} == {"possible", "impossible"}
    assert (row.moments, row.standing) == (2, False)
    assert encode(row, "questions")["answer_value"] == value


@pytest.mark.parametrize(("to", "value"), [("(30 cm, 5 cm)", "possible"), ("(30 cm, -10 cm)", "impossible")])
def test_a_teleport_to_where_it_is_changes_nothing(to: str, value: str) -> None:
    body = f"""
      object ball {{ shape: sphere  size: 8 cm  color: red  on: table at (0, 5 cm) }}
      action go = glide(ball, direction: right, speed: 50 cm/s) for 0.8 s at 0.1 s
      action jump = teleport(ball, to: {to}) at 0.7 s
      observe front at [0 s, 0.9 s]
      question "Is this possible?" {{ answer possible }}
    """
    (found,) = ask_all(body)
    assert isinstance(found, QuestionRow), found
    assert found.value == value


def test_what_is_not_there_cannot_be_gone_through() -> None:
    body = ROLL.format(odd="pass_through(ball, wall) for 0.9 s", pace=FAST)
    (found,) = ask_all(body.replace("fixed: true", "fixed: true  present: false"))
    assert isinstance(found, QuestionRow), found
    assert found.value == "possible"


def test_unseen_change_gives_no_question() -> None:
    late = "paint(ball, color: green) at 0.95 s"
    assert possibility(late).value == "possible", "after the last picture"
    screen = "object screen { shape: box  size: (60 cm, 2 cm, 30 cm)  color: white  on: table at (0, -10 cm) }"
    body = ROLL.format(odd="stop(ball) at 0.5 s", pace=FAST)
    assert refused(screen + body.replace("may hide ball", "seen none")).startswith(
        "alike: no picture shows the violation"
    )


def test_tiny_violation_is_unstable_or_gives_no_question() -> None:
    """An object that is about to stand still is stopped: the answer turns when it is displaced by a little."""
    (found,) = ask_all(ROLL.format(odd="stop(ball) at 0.9 s", pace="0 cm/s"))
    assert isinstance(found, QuestionRow)
    assert found.value == "possible"


def test_engines_agree_on_it() -> None:
    design = Design(spec_of(ROLL.format(odd="pass_through(ball, wall) for 0.9 s", pace=FAST)))
    (row,) = CrossValidation(design, 0, {engine: pair(engine) for engine in ENGINES}, "all").questions()
    assert isinstance(row, QuestionRow), row
    assert [vote.value for vote in row.agreement] == ["impossible"] * len(ENGINES)


GROUP = """
  factor before in [red, blue]
  factor later  in [red, blue]
  nuisance y in 2 cm .. 4 cm
  design groups of 2 {{ cross: [{cross}] }}
  object ball {{ shape: sphere  size: 8 cm  color: before  on: table at (-25 cm, y) }}
  object mark {{ shape: cube  size: 8 cm  color: {mark}  on: table at (-25 cm, 24 cm) }}
  object screen {{ shape: box  size: (20 cm, 2 cm, 16 cm)  color: white  on: table at (0, -8 cm)  fixed: true }}
  action push = launch(ball, direction: right, speed: 60 cm/s, rolling: true) at 0.1 s
  action dye = paint(ball, color: later) at 0.5 s
  horizon 1.2 s
  observe front at [0 s, 1.1 s]
  question "Is this possible?" {{ answer possible }}
"""


def _members(cross: str = "before, later", mark: str = "green") -> dict[int, QuestionRow | Rejected]:
    design = Design(spec_of(GROUP.format(cross=cross, mark=mark)))
    return {index: ask_complete(design, index, pair())[0] for index in design.blocks.members(0)}


def test_every_picture_of_a_group_is_as_often_possible_as_not() -> None:
    rows = list(_members().values())
    assert all(isinstance(row, QuestionRow) for row in rows)
    assert sorted(row.value for row in rows if isinstance(row, QuestionRow)) == ["impossible"] * 2 + ["possible"] * 2


def test_group_with_a_revealing_picture_is_rejected() -> None:
    found = list(_members(mark="if before == later then green else yellow").values())
    assert [(f.reason, "tells the answer" in f.detail) for f in found if isinstance(f, Rejected)] == [
        ("balance", True)
    ] * 4


def test_groups_are_made_whole() -> None:
    assert has_closed_set(spec_of(GROUP.format(cross="before, later", mark="green")))
    assert not has_closed_set(spec_of(ROLL.format(odd="vanish(ball)", pace=FAST)))


def test_the_verbs_that_break_the_laws() -> None:
    assert VIOLATIONS == ("paint", "pass_through", "stop", "teleport", "vanish")


@pytest.mark.parametrize(
    ("question", "message"),
    [
        ("answer possible  options [true, false]", "the options of `answer possible` are possible and impossible"),
        ("answer possible  within 2 cm", "`within` is for answers that are quantities"),
        ("answer possible  distinct by 2 cm", "`distinct by` is for options that are pictures"),
        ("answer possible  counterfactual c { without push }", "counterfactuals are the options of picture questions"),
    ],
)
def test_clauses_that_it_does_not_have(question: str, message: str) -> None:
    body = ROLL.format(odd="vanish(ball) at 0.5 s", pace=FAST).replace("answer possible  may hide ball", question)
    with pytest.raises(SpecError) as raised:
        spec_of(body)
    assert raised.value.diagnostics[0].message.startswith(message)


def test_something_must_be_able_to_be_impossible() -> None:
    with pytest.raises(SpecError) as raised:
        spec_of(ROLL.format(odd="glide(wall, direction: left, speed: 1 cm/s) for 0.1 s", pace=FAST))
    (found,) = raised.value.diagnostics
    assert (found.code, "`pass_through`" in found.help) == ("WMS502", True)


def test_possible_may_be_a_name() -> None:
    text = 'use tabletop\ntask t : custom {\n  factor possible in ["yes", "no"]\n  object a { on: table at (0, 0) }\n'
    text += '  observe front at [0 s]\n  question "?" { answer possible  options ["yes", "no"] }\n}\n'
    assert task_from(text).questions[0].sort == "text"
