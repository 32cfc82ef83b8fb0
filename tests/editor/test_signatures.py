"""Signatures, semantic tokens and completion inside the values of texts."""

from pathlib import Path

import pytest

from wmspec.editor.complete import complete
from wmspec.editor.document import Document
from wmspec.editor.semantic_tokens import TYPES, semantic_tokens
from wmspec.editor.signatures import signature_at
from wmspec.editor.start import first_spec

TEXT = """use room

task one : custom {
  factor pace in [0.6, 0.9] m/s  # how fast
  object ball { shape: sphere  size: 14 cm  color: red  on: floor at (0, 0) }
  robot walker_1 : walker { on: floor at (1 m, 0) }
  actions push[2] = launch(ball, direction: left, speed: pace) at 0.2 s when pace > 0.7 m/s
  observe front at [0 s]
  question "At {pace} the {ball.color} one?" {
    answer contact(ball, floor) without push[0]
  }
}
"""


def document(text: str = TEXT) -> Document:
    return Document(Path("one.wms").resolve(), text)


@pytest.mark.parametrize(
    ("before", "label", "active"),
    [
        ("launch(", "launch(object", "object"),
        ("launch(ball, ", "launch(object", "direction"),
        ("launch(ball, direction: left, speed: ", "launch(object", "speed"),
        ("answer contact(ball, ", "contact(object, object", "object"),
        ("launch(ball, direction: toward(", "toward(", "object"),
    ],
)
def test_the_signature_shows_the_argument_that_is_written(before: str, label: str, active: str) -> None:
    text = TEXT[: TEXT.index(before.partition("(")[0])] + before
    found = signature_at(document(text), len(text))
    assert found is not None
    assert found.label.startswith(label)
    assert found.active is not None
    assert found.parameters[found.active].label.startswith(active)


@pytest.mark.parametrize("before", ["size: (", "# launch(", 'question "launch(', "launch(ball)"])
def test_without_a_call_there_is_no_signature(before: str) -> None:
    text = TEXT[: TEXT.index("  object ball")] + before
    assert signature_at(document(text), len(text)) is None


def test_a_word_is_what_its_declaration_is() -> None:
    found = {(TEXT[t.start : t.end], TYPES[t.type], t.modifiers) for t in semantic_tokens(document())}
    assert {
        ("factor", "keyword", 0), ("pace", "parameter", 1), ("pace", "parameter", 0), ("room", "namespace", 0),
        ("ball", "variable", 1), ("ball", "variable", 0), ("launch", "method", 0), ("contact", "function", 0),
        ("push", "event", 1), ("left", "enumMember", 0), ("when", "keyword", 0), ("without", "keyword", 0),
        ("# how fast", "comment", 0), ("14 cm", "number", 0), ("color", "property", 0),
    } <= found  # fmt: skip


@pytest.mark.parametrize("kind", ["prediction", "perception"])
def test_tokens_are_in_order_on_one_line_and_apart(kind: str) -> None:
    text = first_spec("first", kind)
    end = 0
    for token in semantic_tokens(document(text)):
        assert end <= token.start < token.end
        assert "\n" not in text[token.start : token.end]
        end = token.end


@pytest.mark.parametrize(
    ("before", "word"),
    [('question "At {', "pace"), ('question "At {pa', "pace"), ('question "{pace} and {ball.', "color")],
)
def test_values_in_a_text_are_completed(before: str, word: str) -> None:
    at = TEXT.index('question "At')
    text = TEXT[:at] + before + TEXT[TEXT.index(" the {ball") :]
    assert word in [offer.word for offer in complete(document(text), at + len(before)).offers]


@pytest.mark.parametrize("before", ['question "At ', 'question "At {pace} ', "# {"])
def test_text_outside_of_values_is_not_completed(before: str) -> None:
    text = TEXT[: TEXT.index('question "At')] + before
    assert complete(document(text), len(text)).offers == ()


def test_a_set_of_actions_begins_with_a_verb() -> None:
    text = TEXT[: TEXT.index("launch(")]
    assert "launch" in [offer.word for offer in complete(document(text), len(text)).offers]


@pytest.mark.parametrize(("before", "unit"), [("size: 14 ", "cm"), ("size: 14", "cm"), ("horizon 2 ", "s")])
def test_units_follow_a_number_without_one(before: str, unit: str) -> None:
    whole = "  horizon 2 s\n" if before.startswith("horizon") else "  object box_1 { size: 14 cm }\n"
    at = TEXT.index("  observe")
    text = TEXT[:at] + whole + TEXT[at:]
    place = text.index(before.rstrip(), at) + len(before)
    text = text[:place] + text[text.index("\n", place) if before.startswith("horizon") else text.index(" }", place) :]
    assert unit in [offer.word for offer in complete(document(text), place).offers]
