"""Replies are read as they are meant, or not at all."""

from __future__ import annotations

import ast
import math
import re
import sys
from collections import Counter
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tools.replies import LANGUAGES, Labelled, corpus
from wmspec.eval import replies
from wmspec.eval.replies import LETTERS, ORDINALS, choice, is_near, mark, number_in

PICTURES = (None, None, None, None)
CUBES = ("the red cube", "the blue cube", "neither", "the cube")
TRUTH = ("yes", "no")
COUNTS = ("11", "13", "12", "10")


@pytest.mark.parametrize(
    ("text", "options", "place"),
    [
        # nothing but an option
        *[
            (text, PICTURES, 1)
            for text in ("B", "b", "(b)", "**B**", "B.", " B\n", "[B]", "2", "option B", "Option b.")
        ],
        *[(text, PICTURES, 2) for text in ("The third", "the third option", "third one.", "3rd", "Answer: third")],
        *[(text, PICTURES, 3) for text in ("the last one", "\\boxed{D}", "$\\text{D}$", "<answer>D</answer>")],
        *[(text, CUBES, 1) for text in ("the blue cube", "Blue cube.", "a blue cube", "B: the blue cube")],
        ("the cube", CUBES, 3),
        ("Neither.", CUBES, 2),
        ("12", COUNTS, 2),
        ("2", COUNTS, None),  # no option says 2, and the options are numbers themselves
        # announced
        ("Let me look. There are 7 pictures. The answer is (C) because it moves, not B.", PICTURES, 2),
        ("A is tempting. The answer is A. Wait: the answer is D", PICTURES, 3),
        ("The answer is A because it falls", PICTURES, 0),
        ("I'd go with D", PICTURES, 3),
        ("The correct option is: **B**", PICTURES, 1),
        ("C is correct, B is not", PICTURES, 2),
        ("I choose the second option", PICTURES, 1),
        ("The answer is the blue cube.", CUBES, 1),
        ("1. I look.\n2. I think.\nAnswer: D", PICTURES, 3),
        # begun with
        ("B. It rolls on. A ball does.", PICTURES, 1),
        ("B\n\nThe ball rolls on.", PICTURES, 1),
        ("(B) since A cannot be", PICTURES, 1),
        ("No, they do not. Yes?", TRUTH, 1),
        ("Yes - it fits.", TRUTH, 0),
        # mentioned alone
        ("It is not B but C", PICTURES, 2),
        ("I think it's B.", PICTURES, 1),
        ("There are 12 objects, so D", COUNTS, 3),
        # the words of one alone
        ("It is the red cube", CUBES, 0),
        ("There are 13 objects.", COUNTS, 1),
        # thought aloud
        ("<think>A, or B? The answer is B</think>D", PICTURES, 3),
        ("<think>the answer is B, I", PICTURES, None),
        # nothing that can be relied on
        *[
            (text, PICTURES, None)
            for text in (
                "",
                "E",
                "9",
                "A ball moves.",
                "I cannot see pictures",
                "A or B",
                "In the third picture it moves",
            )
        ],
        *[(text, PICTURES, None) for text in ("Picture 2", "the third picture", "The answer is image 3.")],
        ("From picture 1 to picture 2 it falls, so B", PICTURES, 1),
        ("the second picture", ("the first picture", "the second picture"), 1),
        ("Option A shows a ball; option B shows a cube.", PICTURES, None),
        ("the red cube or the blue cube", CUBES, None),
        ("There is no way to tell", TRUTH, None),
    ],
)
def test_a_reply_is_read(text: str, options: tuple[str | None, ...], place: int | None) -> None:
    assert choice(text, options) == place


@pytest.mark.parametrize(
    ("text", "place"),
    [("2", 1), ("(2)", 1), ("2. It falls", 1), ("image 2", 1), ("The answer is 2", 1), ("b", 1), ("1. a\n2. b", None)],
)
def test_where_options_have_numbers(text: str, place: int | None) -> None:
    assert choice(text, PICTURES, "numbers") == place


def test_requested_label_precedes_number_words() -> None:
    assert choice("2", ("4", "3", "2"), "numbers") == 1
    assert choice("2", ("4", "3", "2"), "letters") == 2


@given(st.integers(2, 8), st.data())
def test_every_label_is_read_in_every_dress(count: int, data: st.DataObject) -> None:
    place = data.draw(st.integers(0, count - 1))
    dress = data.draw(
        st.sampled_from(["{}", "({})", "{}.", "**{}**", "Answer: {}", "The answer is ({}).", "{})\nas it falls"])
    )
    label = data.draw(st.sampled_from([LETTERS[place], LETTERS[place].lower()]))
    assert choice(dress.format(label), (None,) * count) == place
    assert choice(dress.format(place + 1), (None,) * count, "numbers") == place
    assert choice(f"The {ORDINALS[place]} one.", (None,) * count) == place


@given(
    st.text() | st.text(alphabet="ABab12 ().:\n*<think>/answer isotn't$\\{}"),
    st.lists(st.none() | st.text(max_size=20), max_size=9),
    st.sampled_from(["letters", "numbers"]),
)
def test_no_reply_is_too_odd(text: str, options: list[str | None], labels: str) -> None:
    place = choice(text, options, labels)
    assert place is None or 0 <= place < len(options)
    value = number_in(text, "m")
    assert value is None or math.isfinite(value)


@pytest.mark.parametrize(
    "piece", ["answer is ", "(", "A ", "not ", "<think>", "<answer>", "\\boxed{", "1,000", "the option ", "\n2."]
)
def test_long_replies_take_no_longer_than_they_must(piece: str) -> None:
    """A rule whose time grows faster than the reply would not come back from this."""
    text = piece * (replies.MAX_REPLY_LENGTH // len(piece))
    choice(text, CUBES)
    number_in(text, "m")


@pytest.mark.parametrize(
    ("text", "unit", "value"),
    [
        ("0.3", "m", 0.3),
        ("30 cm", "m", 0.3),
        ("The answer is 30 cm (0.3 m), as 15 cm * 2", "m", 0.3),
        ("about 1,200", "", 1200),
        ("three", "", 3),
        ("3 balls", "", 3),
        ("45°", "rad", math.pi / 4),
        ("−1.5e-1 m", "m", -0.15),
        ("3 s", "m", None),
        ("between 1 and 2", "", None),
        ("", "", None),
        ("1e999", "", None),
    ],
)
def test_a_number_is_read_in_its_unit(text: str, unit: str, value: float | None) -> None:
    assert number_in(text, unit) == (value if value is None else pytest.approx(value))


@given(st.floats(-100, 100), st.floats(-3, 3))
def test_of_angles_the_shorter_way_counts(truth: float, off: float) -> None:
    turned = truth + off + math.tau
    assert is_near(turned, truth, abs(off) + 1e-6, "rad")
    assert not is_near(turned, truth, abs(off) - 1e-3, "rad") or abs(off) <= 1e-3
    assert not is_near(turned, truth, 3.1)


def test_numbers_within_tolerance_are_right() -> None:
    assert mark("31 cm", (), number=0.3, unit="m", within=0.01).right
    assert not mark("32 cm", (), number=0.3, unit="m", within=0.01).right
    assert not mark("far", (), number=0.3, unit="m", within=0.01).parsed


def test_parser_needs_no_other_module() -> None:
    """It is copied into folders for other tools, where there is no wmspec."""
    for path in Path(replies.__file__).parent.glob("*.py"):
        tree = ast.parse(path.read_text())
        modules = {node.module for node in ast.walk(tree) if isinstance(node, ast.ImportFrom) and not node.level}
        modules |= {name.name for node in ast.walk(tree) if isinstance(node, ast.Import) for name in node.names}
        assert {str(name).split(".")[0] for name in modules} <= set(sys.stdlib_module_names), path


@pytest.fixture(scope="module")
def labelled() -> list[Labelled]:
    return corpus()


def test_the_corpus_is_large_and_varied(labelled: list[Labelled]) -> None:
    assert len(labelled) >= 400
    assert {r.language for r in labelled} == set(LANGUAGES)
    assert len({(r.language, r.options, r.text) for r in labelled}) == len(labelled), "a reply occurs once"
    assert 0.15 < sum(r.label == "-" for r in labelled) / len(labelled) < 0.4
    places = Counter(r.label for r in labelled if r.options == "4" and r.label != "-")
    assert max(places.values()) < 0.4 * places.total(), "one who always takes the same place is caught"


def test_labelled_replies_are_seldom_misread(labelled: list[Labelled]) -> None:
    false = [(r.text, r.label, r.read()) for r in labelled if r.is_false]
    unread = [r.text for r in labelled if r.is_unread]
    assert len(false) <= 0.005 * len(labelled), false
    assert len(unread) <= 0.05 * sum(r.label != "-" for r in labelled), unread


def test_the_place_of_the_truth_is_not_credited(labelled: list[Labelled]) -> None:
    """Replies read the same under other labels: A becomes D, B becomes C, and so on."""
    swapped = str.maketrans("ABCD", "DCBA")
    for reply in labelled:
        names = set(re.findall(r"(?<![A-Za-z])[A-D](?![A-Za-z])", reply.text))
        if reply.options == "4" and names and not re.search(r"\bA [a-z]", reply.text) and reply.language == "en":
            text = re.sub(r"(?<![A-Za-z])[A-D](?![A-Za-z-]|'[a-z])", lambda m: m[0].translate(swapped), reply.text)
            if re.search(r"\bA [a-z]", text) or re.search(r"\d|first|second|third|last|assistantfinal", reply.text):
                continue  # an article, or a position
            place = choice(text, (None,) * 4)
            label = "-" if place is None else LETTERS[place].translate(swapped)
            assert label == reply.read(), reply.text


def test_the_documentation_reads_replies_as_the_parser_does() -> None:
    page = (Path(__file__).parents[2] / "docs/evaluate.md").read_text()
    rows = re.findall(r"^\|[^|]*\| `([^`]+)` \| (\d|unparsed) \|$", page, re.MULTILINE)
    assert len(rows) > 10
    for text, reported in rows:
        place = choice(text, ("the red cube", "the blue cube", "neither"))
        assert reported == ("unparsed" if place is None else str(place + 1)), text
