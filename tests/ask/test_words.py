"""Objects, values and expressions in words."""

from __future__ import annotations

import pytest

from tests.ask.asking import SCENE
from tests.language.specs import task_from
from wmspec.compile.layout.evaluator import Evaluator
from wmspec.runtime.questions.referring_expressions import Ambiguous, group_expression, referring_expression
from wmspec.runtime.questions.verbalize import format_expression, question_text, verbalize, verbalize_option

TASK = """{objects}
  object other {{ shape: cone  color: green  on: table at (0, 20 cm) }}
  observe front at [0 s]
  {more}"""


def values(objects: str, more: str = "") -> Evaluator:
    return Evaluator(task_from(SCENE.format(body=TASK.format(objects=objects, more=more))), {})


def two(first: str, second: str) -> Evaluator:
    return values(f"object a {{ color: red  {first} }}  object b {{ color: red  {second} }}")


@pytest.mark.parametrize(
    ("first", "second", "a", "b"),
    [
        ("shape: cube", "shape: sphere", "the red cube", "the red sphere"),
        ("size: 10 cm", "size: 6 cm", "the larger red cube", "the smaller red cube"),
        ("material: wood", "material: rubber", "the red wooden cube", "the red rubber cube"),
        ("at: (-9 cm, 0, 0)", "at: (9 cm, 0, 0)", "the red cube on the left", "the red cube on the right"),
        ("at: (0, -9 cm, 0)", "at: (0, 9 cm, 0)", "the red cube at the front", "the red cube at the back"),
        ("color: rgb(0.8, 0.1, 0.1)", "color: rgb(0.1, 0.2, 0.8)", "the red cube", "the blue cube"),
        ("part p { size: 2 cm }", "", "the a", "the red cube"),
        ('part p { size: 2 cm }  called: "toy car"', 'called: "crate"', "the red toy car", "the red crate"),
        ('called: "toy car"  material: wood', 'called: "toy car"', "the red wooden toy car", "the red plastic toy car"),
    ],
)
def test_expressions_distinguish_two_objects(first: str, second: str, a: str, b: str) -> None:
    both = two(first, second) if "color" not in first else values(f"object a {{ {first} }}  object b {{ {second} }}")
    assert (referring_expression("a", both), referring_expression("b", both)) == (a, b)


@pytest.mark.parametrize(
    ("cameras", "said"),
    [
        (("front",), "on the left"),
        (("oblique", "top"), "on the left"),
        (("side",), "at the back"),
        (("other",), "on the right"),
        (("front", "other"), "on the left"),
        (("rider",), "on the left"),
    ],
)
def test_left_is_left_in_the_pictures(cameras: tuple[str, ...], said: str) -> None:
    body = """object a { color: red  at: (-9 cm, 0, 0) }  object b { color: red  at: (9 cm, 0, 0) }
      camera other { at: (5 cm, 1 m, 50 cm)  look_at: (0, 0, 0) }
      camera rider { ride: b  at: (0, 0, 10 cm)  look_at: (-1 m, 0, 0) }
      """ + " ".join(f"observe {camera} at [0 s]" for camera in cameras)
    assert referring_expression("a", Evaluator(task_from(SCENE.format(body=body)), {})) == f"the red cube {said}"


def test_absent_objects_need_no_distinction() -> None:
    assert referring_expression("b", two("present: false", "")) == "the red cube"


def test_the_largest_of_three() -> None:
    three = values("".join(f"object {n} {{ color: red  size: {s} cm }} " for n, s in (("a", 4), ("b", 6), ("c", 9))))
    assert referring_expression("a", three) == "the smallest red cube"
    assert referring_expression("c", three) == "the largest red cube"
    with pytest.raises(Ambiguous):
        referring_expression("b", three)


def test_nothing_distinguishes_them() -> None:
    with pytest.raises(Ambiguous, match="`a` and `b` are both a red cube"):
        referring_expression("a", two("", ""))


@pytest.mark.parametrize(
    ("value", "sort", "said", "option"),
    [
        ("left_of", "relation", "to the left of", "to the left of it"),
        ("behind", "relation", "behind", "behind it"),
        ("back_and_forth", "path", "back and forth", "back and forth"),
        (0.3, "length", "30 cm", "30 cm"),
        (0.1 + 0.2, "length", "30 cm", "30 cm"),
        (-0.0, "plain number", "0", "0"),
        (3.0, "plain number", "3", "3"),
        (0.25, "speed", "25 cm/s", "25 cm/s"),
        (2.5, "force", "2.5 kg*m/s^2", "2.5 kg*m/s^2"),
        (True, "truth value", "yes", "yes"),
        ("rgb:0.1,0.25,0.8", "color", "blue", "blue"),
        ("other", "label", "the green cone", "the green cone"),
        ("neither", "label", "neither", "neither"),
        ("under_score", "text", "under_score", "under_score"),
    ],
)
def test_values(value: object, sort: str, said: str, option: str) -> None:
    there = values("")
    assert verbalize(value, sort, there) == said
    assert verbalize_option(value, sort, there) == option


def test_expressions_read_as_they_were_written() -> None:
    spec = values(
        "objects blocks[3] { size: 2 cm  color: red  at: (index * 5 cm, 0, 0) }",
        """question "?" { answer count(blocks)  options [2, 3, 4]  difference (speed(other) + 1 m/s) / speed(other) }
        question "?" { answer if moved(other) then "yes" else "no"  options ["yes", "no"]  difference -other.size }""",
    ).spec
    first, second = spec.questions
    assert first.difference is not None
    assert second.difference is not None
    assert format_expression(first.answer) == "count(blocks)"
    assert format_expression(first.difference.value) == "(speed(other) + 1) / speed(other)"
    assert format_expression(second.difference.value) == "- other.size"
    assert format_expression(second.answer) == "if moved(other) then yes else no"


@pytest.mark.parametrize(
    ("look", "said"),
    [
        ("shape: cube  color: red", "the red cubes"),
        ('shape: box  called: "crate"  color: pick([red, blue], index)', "the crates"),
        ('shape: cube  called: "die"  plural: "dice"  color: red', "the red dice"),
    ],
)
def test_group_has_one_expression_if_nothing_else_matches_it(look: str, said: str) -> None:
    many = f"objects many[3] {{ {look}  at: (index * 20 cm, 0, 0) }}"
    names = tuple(t.name for t in values(many).spec.things if t.set == "many")
    assert verbalize(names, "list of objects", values(many)) == said
    others = f"objects others[3] {{ {look}  at: (index * 20 cm, 50 cm, 0) }}"
    assert group_expression(names, values(f"{many} {others}")) is None


def test_an_article_before_an_object_is_that_of_the_text() -> None:
    question = 'question "The {a} and {other}: does the {a} move, or bathe {other}?" { answer moved(a) }'
    there = values("object a { color: red }", question)
    said = question_text(there.spec.questions[0], there, there)
    assert said == "The red cube and the green cone: does the red cube move, or bathe the green cone?"
