"""`use` with parameters, a choice and a name of its own; variants of a task."""

from pathlib import Path

import pytest

import wmspec
from wmspec.compile.design.design import Design
from wmspec.compile.layout.evaluator import Evaluator
from wmspec.core.diagnostics import Report
from wmspec.lang.check.ir import ir
from wmspec.lang.check.statements.task import check

LIBRARY = '''
"""A shop."""
use rooms
parameter tone = sand
parameter trim = tone
parameter open in ["day", "night"]
let shade = if open == "day" then white else black
light sun { diffuse: 0.8  ambient: 0.4 }
object ground { shape: box  size: (4 m, 4 m, 10 cm)  color: tone  at: (0, 0, -5 cm)  fixed: true }
object walls : bare_room { wall: tone  trim: trim  at: (0, 0, 0)  fixed: true  solid: false }
object crate { shape: cube  size: 10 cm  color: shade  on: ground at (30 cm, 0)  fixed: true }
camera front { at: (0, -180 cm, 90 cm)  look_at: (0, 0, 0) }
'''
TASK = "object ball {{ shape: sphere  size: 10 cm  on: {0}ground }}  observe {0}front at [0 s]"


def tasks(folder: Path, text: str) -> tuple[dict[str, ir.TaskSpec], list[str]]:
    (folder / "shop.wms").write_text(LIBRARY)
    spec = folder / "spec.wms"
    spec.write_text(text)
    report = Report()
    checked = check(spec, report)
    return {task.name: task for task in checked}, [str(d) for d in report.diagnostics if d.severity == "error"]


def names(task: ir.TaskSpec) -> set[str]:
    return {thing.name for thing in task.things if thing.kind != "part"}


def color(task: ir.TaskSpec, name: str) -> ir.Expr:
    return task.thing(name).properties["color"].value


def test_a_parameter_may_be_a_factor_of_the_task(tmp_path: Path) -> None:
    text = "use shop(tone: t)\ntask a : custom { factor t in [red, blue] " + TASK.format("") + " }"
    found, errors = tasks(tmp_path, text)
    assert not errors
    assert color(found["a"], "ground") == color(found["a"], "walls.left") == ir.Ref(name="t")
    assert len(Design(found["a"])) == 2


@pytest.mark.parametrize(
    ("given", "expected"),
    [("", "white"), ('(open: "day")', "white"), ('(open: "night")', "black"), ("(open: when)", "black")],
)
def test_parameter_is_the_first_of_its_list_or_as_given(tmp_path: Path, given: str, expected: str) -> None:
    when = 'factor when in ["night", "day"]'
    found, errors = tasks(tmp_path, f"use shop{given}\ntask a : custom {{ {when} {TASK.format('')} }}")
    assert not errors
    night = next(i for i in Design(found["a"]) if i.factors["when"] == "night")
    assert Evaluator(found["a"], night.values, None, night.key).property("crate", "color") == expected


def test_a_value_stands_for_no_name(tmp_path: Path) -> None:
    model = "parameter kind = true object thing : kind { shape: cube  size: 10 cm  on: ground at (0, 0) }"
    (tmp_path / "odd.wms").write_text('"""Odd."""\nuse floor\n' + model)
    _, errors = tasks(tmp_path, "use odd\ntask a : custom { factor t in [red, blue] observe front at [0 s] }")
    assert any("there is no template `kind`" in error for error in errors)


def test_a_library_with_a_name_of_its_own_clashes_with_nothing(tmp_path: Path) -> None:
    own = "object ground { shape: cube  size: 1 m  at: (0, 0, -1 m)  fixed: true }  camera front { at: (0, -1 m, 1 m) }"
    text = f"use shop as here\ntask a : custom {{ {own} {TASK.format('here.')} observe front at [0 s] }}"
    found, errors = tasks(tmp_path, text)
    assert not errors
    assert names(found["a"]) >= {"ground", "here_ground", "here_crate", "front", "here_front"}
    assert [o.camera for o in found["a"].observations] == ["here_front", "front"]


def test_a_library_used_twice_by_different_names_is_there_twice(tmp_path: Path) -> None:
    uses = "use shop(tone: red) as one only crate  use shop(tone: blue) as other"
    found, errors = tasks(tmp_path, f"{uses}\ntask a : custom {{ {TASK.format('other.')} }}")
    assert not errors
    assert color(found["a"], "one_ground") == ir.Value(value="red")
    assert color(found["a"], "other_walls.left") == ir.Value(value="blue")
    assert "one_front" not in names(found["a"])


def test_chosen_names_bring_their_dependencies(tmp_path: Path) -> None:
    found, errors = tasks(tmp_path, f"use shop only [crate, front]\ntask a : custom {{ {TASK.format('')} }}")
    assert not errors
    assert names(found["a"]) == {"ground", "crate", "front", "ball"}


def test_a_part_or_parameter_with_the_name_of_an_object_does_not_bring_it(tmp_path: Path) -> None:
    stand = "template stand(crate: 2 cm) { part walls { shape: cylinder  radius: crate  height: 10 cm } }"
    pole = "object pole : stand { on: ground at (0, 30 cm) }"
    (tmp_path / "yard.wms").write_text(f"{LIBRARY}\n{stand}\n{pole}\n")
    found, errors = tasks(tmp_path, f"use yard only [pole, front]\ntask a : custom {{ {TASK.format('')} }}")
    assert not errors
    assert names(found["a"]) == {"ground", "pole", "front", "ball"}


def test_each_variant_is_a_task_with_what_is_common(tmp_path: Path) -> None:
    text = """task speed : perception.motion {
      factor tone in [red, blue]
      variant shop { \"\"\"In a shop: which?\"\"\" use shop  let size = 6 cm }
      variant room { use room as shop  object ground { shape: cube  size: 3 cm  on: shop.floor at (1 m, 0) }
                     let size = 4 cm  camera front { at: (0, -1 m, 1 m) } }
      object ball { shape: sphere  size: size  color: tone  on: ground }
      observe front at [0 s]
    }"""
    found, errors = tasks(tmp_path, text)
    assert not errors
    assert list(found) == ["speed_shop", "speed_room"]
    assert found["speed_shop"].title == "In a shop"
    assert "shop_floor" in names(found["speed_room"])
    assert "shop_floor" not in names(found["speed_shop"])


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("use shop(tint: red)", "1:10: `shop` has no parameter `tint`; known here: open, tone, trim"),
        ('use shop(open: "nigt")', '1:16: `shop` has no open "nigt"; did you mean `"night"`?'),
        (
            'factor when in ["day", "noon"]  use shop(open: when)',
            '`shop` has no open "noon"; known here: "day", "night"',
        ),
        ('use shop(open: if 1 < 2 then "day" else "noon")', '1:41: `shop` has no open "noon"'),
        ("use shop(tone: red, tone: blue)", "1:21: `tone` is given twice; give it once"),
        ("use shop only [ground, frnt]", "1:24: there is no `frnt` in `shop`; did you mean `front`?"),
        ("use shop(tone: red)  use shop(tone: blue)", "1:22: `shop` is used twice"),
        ("use shop as here  let here_x = here.grund", "`here.grund` is not known here"),
        ("use shop as here  light lamp { diffuse: 1 }", "1:25: `lamp` is a second light, and there is one sun"),
    ],
)
def test_mistakes_are_reported(tmp_path: Path, text: str, expected: str) -> None:
    _, errors = tasks(tmp_path, f"{text}\ntask a : custom {{ {TASK.format('here.' if ' as here' in text else '')} }}")
    assert any(expected in error for error in errors), errors


def test_parameter_named_like_a_design_is_no_design() -> None:
    text = """
      parameter groups = 1 cm
      task t : custom {
        use tabletop
        factor a in [1, 2]
        factor b in [1, 2]
        design groups of 4 { cross: a  turn: b }
        object o { size: groups * a * b  on: table }
        observe front at [0 s]
        question groups "Is it large?" { answer a > 1 }
      }
    """
    assert wmspec.load(text=text).groups == 4


def test_library_words_keep_their_meaning_in_a_task(tmp_path: Path) -> None:
    aside = "factor side in [left, right] let way = if side == left then -1 else 1"
    side = "object thing { shape: cube  size: 10 cm  color: white  on: ground at (way * 20 cm, 0) }"
    (tmp_path / "aside.wms").write_text(f'"""Aside."""\nuse shop\n{aside}\n{side}\n')
    own = "nuisance left in 0 cm .. 4 cm  factor tone in [red, green]"
    ball = "object ball { shape: sphere  size: 10 cm  color: tone  on: ground at (left, 0) }  observe front at [0 s]"
    found, errors = tasks(tmp_path, f"use aside\ntask a : custom {{ {own} {ball} }}")
    assert not errors
    assert [f.name for f in found["a"].factors] == ["side", "left", "tone"]
    assert {instance.factors["side"] for instance in Design(found["a"])} == {"left", "right"}
