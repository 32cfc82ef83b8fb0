"""Words that overlap: the relation is one, and the catalogue offers no two of them in one question."""

from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from wmspec.api.checking import check_files
from wmspec.lang.check.tables.overlaps import KINDS, is_kind_of
from wmspec.lang.parse.files import library_folder

WORDS = sorted({word for whole, kinds in KINDS.items() for word in (whole, *kinds)})
SPECS = library_folder().parent
MODIFIERS = ["red", "tall", "left", "small"]


@pytest.mark.parametrize(
    ("phrase", "other"),
    [
        ("planks", "wood"),
        ("the marble", "stone"),
        ("a mug", "thing"),  # by cup and vessel
        ("the desk lamp", "the lamp"),
        ("The small red ball", "a red sphere"),
        ("to the left", "left"),
        ("ball", "sphere"),
        ("sphere", "ball"),
    ],
)
def test_a_kind(phrase: str, other: str) -> None:
    assert is_kind_of(phrase, other)


@pytest.mark.parametrize(
    ("phrase", "other"),
    [
        ("wood", "planks"),
        ("the red ball", "the blue sphere"),
        ("no balls", "balls"),
        ("two balls", "balls"),
        ("3 balls", "balls"),
        ("the left one", "the right one"),
        ("in front of it", "behind it"),
        ("yes", "no"),
        ("wood", "wood"),
        ("", "wood"),
        ("mouse", "house"),
    ],
)
def test_no_kind(phrase: str, other: str) -> None:
    assert not is_kind_of(phrase, other)


@given(st.sampled_from(WORDS), st.sampled_from(WORDS), st.sampled_from(WORDS))
def test_a_kind_of_a_kind_is_a_kind(first: str, second: str, third: str) -> None:
    if is_kind_of(first, second) and is_kind_of(second, third):
        assert first == third or is_kind_of(first, third)


@given(st.sampled_from(WORDS), st.sampled_from(WORDS), st.lists(st.sampled_from(MODIFIERS), unique=True))
def test_words_before_a_kind_keep_it_one(kind: str, whole: str, before: list[str]) -> None:
    more = " ".join(["the", *before, kind])
    assert is_kind_of(more, f"a {whole}") == (is_kind_of(kind, whole) or (kind == whole and bool(before)))
    assert not is_kind_of(whole, " ".join([*MODIFIERS, kind]))


@pytest.mark.parametrize("path", sorted(SPECS.glob("p*/**/*.wms")), ids=lambda path: path.stem)
def test_the_catalogue_offers_no_two(path: Path) -> None:
    assert not [str(d) for d in check_files([path]).diagnostics if d.code == "WMS511"]
