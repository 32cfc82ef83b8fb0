"""The names of the public API are made of the words of the glossary."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from wmspec.api import HOMES

TEXT = (Path(__file__).parents[2] / "docs/glossary.md").read_text()
DEFINED = re.findall(r"^\| \*\*(.*?)\*\* \|", TEXT, re.MULTILINE)
TERMS = set(DEFINED)
#: Words of programming, which mean here what they mean everywhere.
ORDINARY = {"all", "bar", "error", "load", "open", "options", "progress", "register", "run", "wms"}
#: Verbs and derived forms: the term that they belong to.
FORMS = {"crosscheck": "agreement", "diagnose": "diagnosis", "generate": "dataset", "questions": "question"}
WORD = re.compile(r"[A-Z]?[a-z]+")


@pytest.mark.parametrize("name", HOMES)
def test_a_public_name_is_made_of_terms(name: str) -> None:
    words = [word.lower() for word in WORD.findall(name)]
    assert not [word for word in words if FORMS.get(word, word) not in TERMS | ORDINARY]


def test_a_term_is_defined_once() -> None:
    assert sorted(DEFINED) == sorted(TERMS)
