"""`legibility off` in a question: checked, formatted, explained and offered."""

from pathlib import Path

import pytest

from tests.language.specs import task_from
from wmspec.core.diagnostics import SpecError
from wmspec.core.places import Source
from wmspec.editor.complete import complete
from wmspec.editor.document import Document
from wmspec.editor.hover import hover
from wmspec.lang.check.tables.vocabulary import LEGIBILITY
from wmspec.lang.parse.format import format_spec

SPEC = """use tabletop
task t : custom {{
  object a {{ shape: cube  size: 6 cm  on: table at (-10 cm, 0) }}
  object b {{ shape: cube  size: 8 cm  on: table at (10 cm, 0) }}
  observe front at [0 s]
  question "Which is larger?" {{
    options    [a, b]
    answer     largest([a, b])
    {}
  }}
}}
"""


@pytest.mark.parametrize(("clause", "legible"), [("", True), ("legibility off", False)])
def test_question_must_be_legible_unless_off(clause: str, legible: bool) -> None:
    assert task_from(SPEC.format(clause)).questions[0].legible is legible


@pytest.mark.parametrize(
    ("clause", "code", "remedy"),
    [
        ("legibility on", "WMS201", "remove the line"),
        ("legibility strict", "WMS201", "write `legibility off`"),
        ("legibility off\nlegibility off", "WMS202", "remove one"),
    ],
)
def test_mistakes_have_a_remedy(clause: str, code: str, remedy: str) -> None:
    with pytest.raises(SpecError) as raised:
        task_from(SPEC.format(clause))
    (found,) = raised.value.diagnostics
    assert found.code == code
    assert remedy in found.help


def test_legibility_is_no_reserved_word() -> None:
    spec = task_from(SPEC.format("legibility off").replace("object a", "let legibility = 3\n  object a"))
    assert [let.name for let in spec.lets] == ["legibility"]


def test_it_has_a_line_of_its_own() -> None:
    text = format_spec(Source("t", SPEC.format("legibility   off")))
    assert "    answer  largest([a, b])\n    legibility off\n" in text


def test_the_editor_offers_and_explains_it() -> None:
    text = SPEC.format("legibility off")
    document = Document(Path("t.wms"), text)
    place = text.index("off\n")
    found = hover(document, place + 1)
    assert found is not None
    assert LEGIBILITY["off"] in found.markdown
    assert {offer.word for offer in complete(document, place).offers} == LEGIBILITY.keys()
