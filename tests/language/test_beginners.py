"""Mistakes of beginners: one message each, at its place, with what to write instead."""

import pytest

from benchmarks.beginners import MISTAKES, SPEC, Mistake, diagnostics, score

#: Points (of 3) that every mistake scores, and that they score on average.
LEAST, MEAN = 2, 2.8


def test_the_spec_is_right() -> None:
    assert diagnostics(SPEC) == ()


@pytest.mark.parametrize("mistake", MISTAKES, ids=lambda mistake: mistake.name)
def test_a_mistake_has_its_message(mistake: Mistake) -> None:
    made = score(mistake)
    assert made.points >= LEAST, made.diagnostics


def test_messages_are_good_on_average() -> None:
    assert len(MISTAKES) >= 60
    assert sum(score(mistake).points for mistake in MISTAKES) / len(MISTAKES) >= MEAN


@pytest.mark.parametrize(
    "text",
    [
        "let low = 1\n  let high =\n    if n == 2 then low else 2",
        "let words = [1, 2]  # a comment, not #abc",
        "let wide = 5 mm  #ffcc00 is a comment",
        "object o { size: 4 cm  on: floor at (1 m, 0)  present: not (n == 2) }",
        "objects many[n - 1] { size: 4 cm  on: floor at (1 m, 10 cm * index) }",
    ],
)
def test_nothing_valid_is_taken_for_an_idiom(text: str) -> None:
    assert [
        d for d in diagnostics(SPEC.replace("horizon 1.2 s", f"{text}\n  horizon 1.2 s")) if d.severity == "error"
    ] == []
