"""Common mistakes in a first spec: each is reported once, at its place, with its correction."""

from __future__ import annotations

from pathlib import Path

import pytest
from click.testing import CliRunner

from wmspec.cli import main
from wmspec.compile.lint.dry_run import dry_run
from wmspec.core.diagnostics import Diagnostic, Report
from wmspec.core.places import Location, Source, Span
from wmspec.lang.check.statements.task import check_program
from wmspec.lang.parse.load import load_source

SPEC = """use room

task first : custom {
  factor tone in [red, blue]
  factor pace in [0.6, 0.9] m/s
  nuisance turn in -20 deg .. 20 deg
  let start = -44 cm
  object ball  { shape: sphere  size: 14 cm  color: tone  on: floor at (start, 0) }
  object crate { shape: cube  size: 14 cm  color: green  on: floor at (10 cm, 0)  yaw: turn }
  action push = launch(ball, direction: toward(crate), speed: pace) at 0.2 s
  horizon 1.2 s
  observe front at [0 s, 0.3 s]
  question "The {tone} ball goes towards the box. What comes next?" {
    answer frame(front, end)
    counterfactual slower { action push.speed: push.speed * 0.3 }
    counterfactual none { without push }
    ensure contact(ball, crate)
  }
}
"""

#: What is written, what instead of it, the code, the line, and what the remedy or the message says.
MISTAKES = {
    "camera inside an object": (
        "observe front",
        "camera eye { at: (10 cm, 0, 7 cm)  look_at: (1 m, 0, 0) }\n  observe eye",
        "WMS605",
        12,
        "move one of them",
    ),
    "object 60 m away": ("on: floor at (10 cm, 0)", "at: (10 cm, 60 m, 7 cm)", "WMS605", 9, "unit"),
    "ball of 500 t": (
        "size: 14 cm  color: tone",
        "size: 14 cm  mass: 500 t  color: tone",
        "WMS606",
        8,
        "check its unit",
    ),
    "inside a pipe that is no part": (
        "object crate {",
        "object pipe { shape: tube  on: floor at (60 cm, 40 cm) }  object pea { inside: pipe }  object crate {",
        "WMS304",
        9,
        "part wall { shape: tube",
    ),
    "a ball of a millionth of a gram": (
        "size: 14 cm  color: tone",
        "size: 14 cm  mass: 0.001 mg  color: tone",
        "WMS606",
        8,
        "check its unit",
    ),
    "moments of a millstone": (
        "size: 14 cm  color: tone",
        "size: 14 cm  mass: 1 kg  moments: (9 kg*m^2, 9 kg*m^2, 9 kg*m^2)  color: tone",
        "WMS606",
        8,
        "check its unit",
    ),
    "the thing asked about is hidden": (
        "horizon",
        "object wall { shape: box  size: (50 cm, 2 cm, 50 cm)  at: (-44 cm, -20 cm, 25 cm)  fixed: true }\n  horizon",
        "WMS605",
        8,
        "move one of them",
    ),
    "a text over two lines": ("box. What comes", "box.\n  What comes", "WMS102", 13, 'in the next: `"..." "..."`'),
    "a question in three quotes": (
        '"The {tone} ball goes towards the box. What comes next?"',
        '"""The {tone} ball goes towards the box.\n  What comes next?"""',
        "WMS101",
        13,
        'as several: `"..." "..."`',
    ),
    "pieces of a text with a comma": ("box. What comes", 'box.", "What comes', "WMS101", 13, "remove it"),
    "a ball at 90 m/s": ("speed: pace", "speed: pace * 100", "WMS606", 10, "unit"),
    "unsorted times": ("[0 s, 0.3 s]", "[0.3 s, 0 s]", "WMS604", 12, ""),
    "duplicate times": ("[0 s, 0.3 s]", "[0 s, 0 s, 0.3 s]", "WMS604", 12, ""),
    "unused let": ("(start, 0)", "(-44 cm, 0)", "WMS410", 7, "remove"),
    "two launches at one instant": (
        "horizon",
        "action twice = launch(ball, direction: left, speed: 1 m/s) at 0.2 s\n  horizon",
        "WMS607",
        11,
        "leave one out",
    ),
    "set of -2": ("horizon", "objects many[-2] { on: floor }\n  horizon", "WMS304", 11, "from 0 on"),
    "a counterfactual twice": (
        "slower { action push.speed: push.speed * 0.3 }",
        "slower { action push.speed: 0.3 m/s }\n    counterfactual again { action push.speed: 0.3 m/s }",
        "WMS503",
        16,
        "",
    ),
    "an ensure that never holds": ("contact(ball, crate)", "ball.size > 20 cm", "WMS509", 17, ""),
    "Unicode minus": ("-44", "−44", "WMS102", 7, "`-`"),
    "factro": ("factor pace", "factro pace", "WMS101", 5, "`factor`"),
    "objct": ("object ball", "objct ball", "WMS101", 8, "`object`"),
    "Horizon": ("horizon", "Horizon", "WMS101", 11, "`horizon`"),
    "smart quotes": (
        '"The {tone} ball goes towards the box. What comes next?"',
        "“The {tone} ball goes towards the box. What comes next?”",
        "WMS102",
        13,
        '"The {tone} ball',
    ),
    "unclosed string": ('next?"', "next?", "WMS102", 13, "between two"),
    "hyphen in a name": ("object ball ", "object red-ball ", "WMS101", 8, "`red_ball`"),
    "&&": ("contact(ball, crate)", "contact(ball, crate) && true", "WMS102", 17, "`and`"),
    "= in a condition": ("contact(ball, crate)", "tone = red", "WMS101", 17, "`==`"),
    "if without else": ("color: green", "color: if tone == red then green", "WMS101", 9, "else"),
    "True": ("on: floor at (10 cm, 0)", "fixed: True  on: floor at (10 cm, 0)", "WMS201", 9, "`true`"),
    "a shape that is none": ("shape: cube", "shape: block", "WMS201", 9, "`box`"),
    "ball as a verb": ("launch(ball,", "lanch(ball,", "WMS204", 10, "`launch`"),
    "rooom": ("use room", "use rooom", "WMS207", 1, "`room`"),
    "inch": ("size: 14 cm  color: tone", "size: 5 inch  color: tone", "WMS103", 8, "cm"),
    "a comment by slashes": ("horizon 1.2 s", "horizon 1.2 s // long enough", "WMS102", 11, "`#`"),
    "an extra brace": ("ensure contact(ball, crate)\n  }", "ensure contact(ball, crate)\n  }}", "WMS101", 18, ""),
    "a missing brace": ("yaw: turn }", "yaw: turn", "WMS101", 9, "`}`"),
    "a speed in cm": ("[0.6, 0.9] m/s", "[0.6, 0.9] m", "WMS301", 10, ""),
    "Object": ("object crate", "Object crate", "WMS101", 9, "`object`"),
    "a comma between properties": ("shape: cube  size", "shape: cube,  size", "WMS101", 9, "remove"),
    "a semicolon": ("horizon 1.2 s", "horizon 1.2 s;", "WMS102", 11, "remove"),
    "an unknown camera": ("observe front", "observe frnt", "WMS201", 12, "`front`"),
    "weight": ("size: 14 cm  color: tone", "size: 14 cm  weight: 1 kg  color: tone", "WMS203", 8, "`mass`"),
    "colour": ("color: green", "colour: green", "WMS203", 9, "`color`"),
    "a colour that is none": ("color: green", "color: gren", "WMS201", 9, "`green`"),
}


def reported(text: str) -> tuple[Diagnostic, ...]:
    """All diagnostics of a text."""
    report = Report()
    for spec in check_program(load_source(Source("first.wms", text), Path(), report), report):
        dry_run(spec, report)
    return report.diagnostics


def test_the_spec_is_right() -> None:
    assert reported(SPEC) == ()


@pytest.mark.parametrize(("written", "instead", "code", "line", "remedy"), MISTAKES.values(), ids=MISTAKES)
def test_one_mistake_is_reported_once_at_its_place_with_a_remedy(
    written: str, instead: str, code: str, line: int, remedy: str
) -> None:
    assert SPEC.count(written) == 1
    (only,) = reported(SPEC.replace(written, instead))
    assert isinstance(only.place, Span | Location)
    assert (only.code, only.place.line) == (code, line)
    assert only.help
    assert remedy in only.help


VARIANTS = """task tone : custom {
  factor tint in [red, blue]
  design groups of 20 { cross: tint }
  variant room     { use room      object ball { color: tint  at: (0, 0, 10 cm) } }
  variant tabletop { use tabletop  object ball { color: tint  at: (0, 0, 10 cm) } }
  observe front at [0 s]
  question "Which?" { answer frame(front, 0 s)  options orbit of tint }
}
"""


@pytest.mark.parametrize(
    ("written", "instead", "remedy"), [("factor tint", "factor tnit", "tnit"), ("groups", "gruops", "groups")]
)
def test_mistake_is_reported_once_for_all_variants_and_consequences(written: str, instead: str, remedy: str) -> None:
    (only,) = reported(VARIANTS.replace(written, instead))
    assert only.code == "WMS201"
    assert only.help == f"did you mean `{remedy}`?"


def test_two_tasks_of_one_name_are_an_error() -> None:
    (only,) = reported(SPEC + SPEC.partition("\n\n")[2])
    assert only.code == "WMS202"
    assert "another name" in only.help


@pytest.mark.parametrize(
    ("words", "remedy"), [(["chekc", "my.wms"], "check"), (["explain", "WMS999"], "WMS"), (["explain", "wms203"], "")]
)
def test_misspelled_commands_and_codes_are_reported(words: list[str], remedy: str) -> None:
    result = CliRunner().invoke(main, words)
    assert remedy in result.output
    assert "Traceback" not in result.output
