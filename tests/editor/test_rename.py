"""Renaming: every declared name, also one that is a word of the language, and no word with it."""

from pathlib import Path

import pytest

from wmspec.core.diagnostics import Report, WmsError
from wmspec.core.places import Source
from wmspec.editor.document import Document
from wmspec.editor.names import Names
from wmspec.editor.rename import rename_places
from wmspec.lang.check.statements.task import check_program
from wmspec.lang.parse.load import load_source

TEXT = """use tabletop

template pin(tall: 6 cm) { part stem { shape: cylinder  size: (2 cm, tall) } }

task which_moves : perception.motion.presence {
  factor   mover in [left, right]
  factor   tone  in [red, blue]
  nuisance angle[2] in -10 deg .. 10 deg
  design groups of 4 { cross: [mover, tone]  balance: low }
  object left  { shape: sphere  size: 8 cm  color: tone   on: table at (-20 cm, 10 cm) }
  object right { shape: sphere  size: 8 cm  color: green  on: table at (-20 cm, -10 cm) }
  object mark : pin { tall: 4 cm  on: table at (30 cm, 0) }
  objects dots[2] { shape: cube  size: 2 cm  on: table at (10 cm * index, 20 cm) }
  action go = launch(mover, direction: left, speed: 30 cm/s, rolling: true) at 0.2 s
  actions roll[2] = launch(dots[index], direction: angle[index], speed: 30 cm/s) at 0.2 s when tone == red
  observe front at [0 s, 0.5 s, 1 s]
  question low "Does the {left.color} ball move?" {
    answer displacement(left) > 5 cm
  }
  question after_all "What then?" {
    answer frame(front, end) without dots[0]
    counterfactual none { without go }
  }
}
"""


def document(text: str = TEXT) -> Document:
    return Document(Path("which_moves.wms").resolve(), text)


def declared() -> list[str]:
    """The names that the text declares."""
    names, made = Names(document()), dict[str, None]()
    for each in names.occurrences:
        if each.declared.path == document().path and each.declared.start == each.span.start:
            made[each.span.text] = None
    return list(made)


def renamed(name: str, text: str = TEXT) -> str:
    made = document(text)
    occurrence = next(o for o in Names(made).occurrences if o.span.text == name)
    for span in sorted(rename_places([made], occurrence, "another_1")[made.path], key=lambda s: -s.start):
        text = text[: span.start] + "another_1" + text[span.end :]
    return text


def test_all_kinds_of_names_are_declared_here() -> None:
    assert {
        "pin",
        "tall",
        "stem",
        "which_moves",
        "mover",
        "angle",
        "left",
        "mark",
        "dots",
        "go",
        "roll",
        "low",
        "none",
    } <= set(declared())


@pytest.mark.parametrize("name", declared())
def test_a_renamed_spec_has_no_mistakes(name: str) -> None:
    text, report = renamed(name), Report()
    assert text != TEXT
    check_program(load_source(Source("which_moves.wms", text), Path(), report), report)
    assert [d for d in report.diagnostics if d.severity == "error"] == []


def test_a_word_of_the_language_stays() -> None:
    text = renamed("left")
    assert "direction: left" in text
    assert text.count("left") == 1


def test_a_word_in_a_spec_with_mistakes_is_not_renamed() -> None:
    with pytest.raises(WmsError, match="has mistakes"):
        renamed("left", TEXT.replace("size: 8 cm", "size: 8 s"))
