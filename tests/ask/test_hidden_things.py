"""`may hide` and `seen`: what must be visible when, and the same for what is hidden and for what has vanished."""

from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.ask.asking import ask_all, one, refused, spec_of
from tests.examples import examples
from wmspec.core.diagnostics import SpecError
from wmspec.dataset.build.columns import optional_columns
from wmspec.dataset.build.rows import encode
from wmspec.editor.complete import complete
from wmspec.editor.document import Document
from wmspec.runtime.questions.model import QuestionRow

SCENE = """
  object ball   {{ shape: sphere  size: 8 cm  color: red  on: table at (0, 10 cm) }}
  object block  {{ shape: cube  size: 6 cm  color: blue  on: table at (-25 cm, 0) }}
  object screen {{ shape: box  size: (20 cm, 2 cm, 20 cm)  color: white  on: table at (25 cm, 12 cm) }}
  {event}
  horizon 1 s
  observe front at [0 s, 0.4 s, 0.8 s]
  question "Which colour does the ball have?" {{
    {question}
    {clause}
  }}
"""
HIDDEN = "action shut = teleport(screen, to: (0, -2 cm)) at 0.2 s"
GONE = "action shut = teleport(screen, to: (0, 30 cm)) at 0.2 s  action gone = vanish(ball) at 0.2 s"
LABEL = "options [red, blue]  answer ball.color"
QUESTIONS = (
    LABEL,
    "answer height(block) > height(ball, at: 0 s)",
    "answer height(ball, at: 0 s)  within 1 cm",
    "answer frame(front, 0.8 s)  counterfactual other { state block.color: green }",
)
CLAUSES = (
    "",
    "may hide ball",
    "seen none",
    "may hide [ball, block]",
    "seen ball at 0 s",
    "seen [ball] at [0 s, 0.4 s]",
)


def body(event: str, clause: str, question: str = LABEL) -> str:
    return SCENE.format(event=event, clause=clause, question=question)


@pytest.mark.parametrize("event", [HIDDEN, GONE], ids=["hidden", "gone"])
def test_by_default_everything_is_seen_all_the_time(event: str) -> None:
    assert refused(body(event, "")).startswith("unseen: ball from front at 0.4 s")
    assert refused(body(event, "may hide block")).startswith("unseen: ball from front at 0.4 s")
    assert one(body("", "")).value == "red"


@pytest.mark.parametrize("event", [HIDDEN, GONE], ids=["hidden", "gone"])
@pytest.mark.parametrize("clause", ["may hide ball", "seen none", "seen ball at [0 s]", "seen [ball, block] at 0 s"])
def test_a_question_may_be_about_what_is_hidden(event: str, clause: str) -> None:
    row = one(body(event, clause))
    assert row.visible is not None
    shares = {part.picture: part.share for part in row.visible if part.name == "ball"}
    assert shares[0] > 0.95
    assert shares[1] == shares[2] == 0


@pytest.mark.parametrize("event", [HIDDEN, GONE], ids=["hidden", "gone"])
def test_seen_clause_requires_visibility(event: str) -> None:
    assert refused(body(event, "seen ball at [0 s, 0.8 s]")).startswith("unseen: ball from front at 0.8 s")
    assert "the pictures are taken at 0 s, 0.4 s, 0.8 s" in refused(body(event, "seen ball at [0.3 s]"))


def test_seen_clause_covers_objects_outside_the_text() -> None:
    wall = "object wall { size: 4 cm  color: green  on: table at (5 cm, 2 cm) }"
    assert one(body(f"{HIDDEN} {wall}", "may hide ball")).value == "red"
    assert refused(body(f"{HIDDEN} {wall}", "may hide ball  seen wall at [0.8 s]")).startswith("unseen: wall")


@examples(8, 25, deadline=None)
@given(
    st.sampled_from(CLAUSES),
    st.sampled_from(QUESTIONS),
    st.sampled_from([0.1, 0.4, 0.6, 0.9]),
    st.sampled_from(["", "may hide screen"]),
)
def test_hidden_and_vanished_are_treated_alike(clause: str, question: str, time: float, more: str) -> None:
    """By every gate: the same outcome and the same columns, at any time and for any question."""
    clause = clause if clause == "seen none" else f"{clause} {more}"
    outcomes: list[tuple[object, ...]] = []
    for event in (HIDDEN, GONE):
        (found,) = ask_all(body(event.replace("0.2 s", f"{time} s"), clause, question))
        if isinstance(found, QuestionRow):
            parts = tuple((p.picture, p.name, round(p.share, 2)) for p in found.visible or () if p.name == "ball")
            measures = {each.name for each in found.legibility}
            outcomes.append((found.value, parts, measures))
        else:
            outcomes.append((found.reason, found.detail.split(":")[0], set()))
    assert outcomes[0] == outcomes[1]


def test_the_row_has_a_column_only_where_something_may_hide() -> None:
    clause = "may hide ball"
    assert list(optional_columns(spec_of(body(HIDDEN, clause)))) == ["context_visible"]
    assert optional_columns(spec_of(body("", ""))) == {}
    made = encode(one(body(HIDDEN, clause)), "questions")
    assert [part["name"] for part in made["context_visible"]] == ["ball"] * 3
    assert "context_visible" not in encode(one(body("", "")), "questions")


@pytest.mark.parametrize(
    ("clause", "code", "remedy"),
    [
        ("seen ball", "WMS304", "say when: `seen ball at [0 s]`"),
        ("seen none at [0 s]", "WMS304", "remove them"),
        ("may hide red", "WMS302", ""),
        ("seen ball at [3 cm]", "WMS302", ""),
        ("may hide bal", "WMS201", "did you mean `ball`?"),
        ("may hide ball  seen ball at 0 s", "WMS202", "remove one"),
        ("may hide ball  seen none", "WMS202", "remove one"),
    ],
)
def test_mistakes_have_a_remedy(clause: str, code: str, remedy: str) -> None:
    with pytest.raises(SpecError) as raised:
        spec_of(body("", clause))
    assert (raised.value.diagnostics[0].code, remedy in raised.value.diagnostics[0].help) == (code, True)


def test_the_words_of_the_clauses_are_no_reserved_words() -> None:
    spec = spec_of(body("let may = 1  let seen = 2  let hide = 3", "may hide ball"))
    assert [let.name for let in spec.lets] == ["may", "seen", "hide"]


def test_the_editor_offers_objects() -> None:
    text = "use tabletop\ntask t : custom {\n" + body("", "may hide ball") + "}"
    document = Document(Path("t.wms"), text)
    offered = {offer.word for offer in complete(document, text.index("may hide ") + len("may hide ")).offers}
    assert {"ball", "block", "screen"} <= offered


@pytest.mark.parametrize(
    ("place", "word"), [("0, 20 cm", "in_front_of"), ("0, -20 cm", "behind"), ("-20 cm, 0", "left_of")]
)
def test_bodiless_viewer_has_a_direction(place: str, word: str) -> None:
    """`me` looks away from the camera, is neither solid nor drawn, and may be the second of a relation."""
    text = f"""
      object me {{ shape: cube  size: 4 cm  solid: false  drawn: false  at: (0, 0, 20 cm)  yaw: 90 deg }}
      action go = glide(me, direction: away, speed: 1 cm/s) for 0.1 s
      horizon 0.2 s
      object ball {{ shape: sphere  size: 8 cm  color: red  on: table at ({place}) }}
      observe front at [0 s]
      question "Where is it from there?" {{
        options [left_of, right_of, in_front_of, behind]
        answer  relation(ball, me, seen_from: me)
        may hide me
      }}
    """
    (found,) = ask_all(text)
    assert isinstance(found, QuestionRow), found
    assert [option.name for option in found.options if option.kind == "truth"] == [word]
