"""`make generate` renews every generated file, and every recipe names it."""

from __future__ import annotations

import re
from pathlib import Path

from tests.docs.test_pages import CONTRIBUTING
from tools import gallery

ROOT = Path(__file__).parents[2]


def test_every_tool_that_can_tell_whether_its_files_are_current_is_run() -> None:
    (steps,) = re.findall(r"^generate:.*\n((?:\t.*\n)+)", (ROOT / "Makefile").read_text(), re.MULTILINE)
    checked = {path.name for path in (ROOT / "tools").glob("*.py") if '"--check"' in path.read_text()}
    assert checked
    assert checked == set(re.findall(r"tools/(\w+\.py)", steps))
    assert "docs/schema.json" in steps


def test_every_recipe_ends_with_a_check() -> None:
    recipes = re.findall(r"^### Add .*?(?=^##|\Z)", CONTRIBUTING, re.MULTILINE | re.DOTALL)
    assert len(recipes) >= 6
    for recipe in recipes:
        assert "`make generate`" in re.findall(r"^\d\. .*(?:\n   .*)*", recipe, re.MULTILINE)[-1], recipe[:40]


def test_the_tables_of_examples_and_objects_are_current() -> None:
    for page, text in gallery.pages():
        assert page.read_text() == text
