"""Templates, parts and sets mean what they would mean written out, and can be made in Python."""

from dataclasses import replace
from pathlib import Path
from typing import Any

from tests.language.specs import task_from
from tests.language.test_format import without_places
from wmspec.core.diagnostics import Report
from wmspec.core.places import Source
from wmspec.lang.check.ir import record
from wmspec.lang.check.ir.ir import Call, Items, Operation, Property, Ref, TaskSpec, Value
from wmspec.lang.check.statements.builder import action, compound, factor, joint, objects, observe, robot, task, thing
from wmspec.lang.check.statements.task import check_program
from wmspec.lang.parse.load import load_source

HEAD = """
object table { shape: box  size: (1 m, 1 m, 4 cm)  at: (0, 0, -2 cm)  fixed: true }
camera front { at: (0, -2 m, 1 m) }
"""
TABLE = thing("object", "table", shape="box", size=(1, 1, 0.04), at=(0, 0, -0.02), fixed=True)
FRONT = thing("camera", "front", at=(0, -2, 1))


def checked(body: str, head: str = "") -> TaskSpec:
    return task_from(f"{head}{HEAD}task t : custom {{\n{body}\nobserve front at [0 s]\n}}\n")


def plain(spec: TaskSpec) -> Any:
    return without_places(record.plain(spec))


def codes(body: str, head: str = "") -> list[str]:
    report = Report()
    text = f"{head}{HEAD}task t : custom {{\n{body}\nobserve front at [0 s]\n}}\n"
    check_program(load_source(Source("test.wms", text), Path(), report), report)
    return [d.code for d in report.diagnostics]


SHELF = """
template shelf(width: 30 cm, hollow: 12 cm, deep: hollow / 2) {
  color: oak
  on: table at (1 cm, 2 cm)
  part left { shape: box  size: (2 cm, deep, hollow)  at: (-width / 2, 0 cm, hollow / 2) }
}
"""


def test_a_template_is_the_object_written_out() -> None:
    made = checked("object a : shelf { width: 20 cm  friction: 0.3 }", SHELF)
    written = checked(
        """object a {
          color: oak  on: table at (1 cm, 2 cm)  friction: 0.3
          part left { shape: box  size: (2 cm, 12 cm / 2, 12 cm)  at: (-20 cm / 2, 0 cm, 12 cm / 2) }
        }"""
    )
    assert plain(made) == plain(written)


def test_an_objects_own_properties_and_parts_go_before_and_after_the_templates() -> None:
    spec = checked("object a : shelf { color: red  on: table  part top { shape: cube } }", SHELF)
    whole = spec.thing("a")
    assert whole.properties["color"].value == Value(value="red")
    assert whole.properties["at"].value == Items(items=(Value(value=0.0), Value(value=0.0)))
    assert [t.name for t in spec.things if t.of == "a"] == ["a.left", "a.top"]


def test_given_value_is_checked_at_its_place() -> None:
    """The `width` that is given is the task's, not the template's parameter of that name, nor is `hollow`."""
    body = "factor width in [10, 20] cm\nlet hollow = width * 2\nobject a : shelf { hollow: width  width: hollow }"
    left = checked(body, SHELF).thing("a.left").properties
    assert left["size"].value == Items(
        items=(
            Value(value=0.02),
            Operation(operator="/", operands=(Ref(name="width"), Value(value=2.0))),
            Ref(name="width"),
        )
    )


def test_a_mistake_in_a_template_that_nothing_uses_is_found() -> None:
    assert codes("", "template odd(wide: 3 cm) { shape: cube  mass: wide }") == ["WMS301"]
    assert codes("", "template set_like(wide: 3 cm) { shape: cube  size: wide }") == ["WMS410"]  # unused


def test_parts_look_like_their_object_where_they_do_not_say() -> None:
    spec = checked(
        "object a { color: red  material: wood  part b { shape: cube }  part c { shape: cube  color: blue } }"
    )
    of = Property(owner=Value(value="a"), name="color")
    assert spec.thing("a.b").properties["color"].value == of
    assert spec.thing("a.c").properties["color"].value == Value(value="blue")
    assert spec.thing("a.c").properties["material"].value == replace(of, name="material")
    assert "shape" not in spec.thing("a").properties
    assert "size" not in spec.thing("a").properties


def test_a_set_is_its_members_written_out() -> None:
    made = checked("factor n in [1, 3]\nobjects a[n] { shape: cube  size: 3 cm + index * 1 cm  on: table }")
    written = checked(
        "factor n in [1, 3]\n"
        + "\n".join(
            f"object a_{i} {{ shape: cube size: 3 cm + {i} * 1 cm on: table present: {i} < n }}" for i in range(3)
        )
    )
    unset = [replace(t, set="") for t in made.things]
    assert plain(replace(made, things=tuple(unset))) == plain(written)
    assert [t.set for t in made.things if t.kind == "object"] == ["", "a", "a", "a"]


def test_a_set_whose_number_never_changes_is_always_there() -> None:
    spec = checked("let n = 1 + 1\nobjects a[2] { on: table }\nobjects b[n] { on: table  present: index == 0 }")
    assert spec.thing("a_1").properties["present"].value == Value(value=True)
    assert str(spec.thing("b_1").properties["present"].value).count("operator='<'") == 1


def test_a_set_as_a_value_is_those_that_are_there() -> None:
    body = 'factor n in [1, 2]\nobjects a[n] { on: table }\nquestion "?" { answer count(a)  options [n, n + 1] }'
    answer = checked(body).questions[0].answer
    members = Items(items=(Value(value="a_0"), Value(value="a_1")))
    assert answer == Call(function="count", arguments=(Call(function="present", arguments=(members,)),))


def test_the_largest_number_is_looked_for_over_all_factors() -> None:
    body = "factor n in [2, 3]\nfactor m in [1, 4]\nlet more = n * m\nobjects a[more - 1] { on: table }"
    assert sum(t.set == "a" for t in checked(body).things) == 11


def test_expansion_of_a_small_text_is_bounded() -> None:
    doubling = ", ".join(["p0: 1", *(f"p{i}: p{i - 1} + p{i - 1}" for i in range(1, 60))])
    assert codes("object a : t { }", f"template t({doubling}) {{ shape: cube  size: p59 * 1 cm }}\n") == ["WMS105"]
    members = "\n".join(f"objects a{i}[500] {{ on: table }}" for i in range(12))
    assert set(codes(members)) == {"WMS105"}


def test_long_chains_are_reported_and_not_followed() -> None:
    lets = "let a0 = 1\n" + "\n".join(f"let a{i} = a{i - 1} + 1" for i in range(1, 400))
    backwards = "\n".join(f"action a{i} = launch(b, 0 deg, 1 m/s) after a{i + 1}" for i in range(400))
    last = "action a400 = launch(b, 0 deg, 1 m/s)\nobject b { on: table }\n"
    assert set(codes(lets)) == set(codes(last + backwards)) == {"WMS105"}


def test_all_of_it_can_be_made_in_python() -> None:
    arm = robot("arm", "panda", on="table", at=(-0.3, 0))
    n = Ref(name="n")
    made = task(
        "t",
        factor("n", [1, 2]),
        factor("spot", [(0.1, 0), (0, 0.1)], unit="m"),
        TABLE,
        FRONT,
        *compound("rack", {"left": {"shape": "box", "size": (0.02, 0.1, 0.1)}}, on="table", at=Ref(name="spot")),
        *objects("a", 2, lambda i: {"shape": "cube", "size": 0.03 + i * 0.01, "on": "table"}, count=n),
        joint("swing", "hinge", of="a_0", at=(0, 0, 0), low=0, stiffness=2),
        arm,
        action("grab", "pick", by=arm, object="a_0", height=0.1, duration=2),
        action("turn", "drive", joint="swing", target=1),
        observe("front", [0], ("rgb", "ids")),
        tolerances={"event": 0.03},
    )
    text = f"""{HEAD}
    task t : custom {{
      factor n in [1, 2]
      factor spot in [(10 cm, 0), (0, 10 cm)]
      object rack {{ part left {{ shape: box  size: (2 cm, 10 cm, 10 cm) }}  on: table at spot }}
      objects a[n] {{ shape: cube  size: 0.03 m + index * 0.01 m  on: table }}
      joint swing : hinge {{ of: a[0]  at: (0, 0, 0)  low: 0 deg  stiffness: 2 }}
      robot arm : panda {{ on: table at (-30 cm, 0) }}
      action grab = arm.pick(a[0], height: 10 cm) for 2 s
      action turn = drive(swing, 1 rad)
      observe front at [0 s] as [rgb, ids]
      tolerance event 30 ms
    }}"""
    assert plain(made) == plain(task_from(text))
