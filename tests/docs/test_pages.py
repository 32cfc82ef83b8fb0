"""What the pages say of the code is so: sessions run, files exist, snippets are those of the tests."""

from __future__ import annotations

import doctest
import re
import textwrap
from pathlib import Path

import pytest

from tests.engines import installed

ROOT = Path(__file__).parents[2]
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]
RECIPES = ROOT / "tests/recipes"
CONTRIBUTING = (ROOT / "docs/contributing.md").read_text()
NAMED = re.compile(r"(?:`|python )((?:wmspec|backends|tests|tools|docs|specs|benchmarks)/[\w./-]+)`")
#: Files that a recipe makes.
MADE = {"wmspec/sim/shapes/prism.py", "wmspec/runtime/questions/kinds/names.py"}


@pytest.mark.engine
def test_the_walk_of_a_spec_is_a_session_that_runs(monkeypatch: pytest.MonkeyPatch) -> None:
    installed("mujoco")
    monkeypatch.chdir(ROOT)
    failed, tried = doctest.testfile(str(ROOT / "docs/architecture.md"), module_relative=False)
    assert tried > 20
    assert failed == 0


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_every_file_that_is_named_exists(page: Path) -> None:
    named = set(NAMED.findall(page.read_text())) - MADE
    assert not [name for name in named if not (ROOT / name).exists()]


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_code_is_closed_and_tables_have_a_head_and_equal_rows(page: Path) -> None:
    text = page.read_text()
    assert len(re.findall(r"^ *```", text, re.MULTILINE)) % 2 == 0
    outside = re.sub(r"^ *```.*?^ *```", "", text, flags=re.MULTILINE | re.DOTALL)
    for table in re.findall(r"(?:^ *\|.*\n)+", outside, re.MULTILINE):
        columns = {len(re.sub(r"\\\||`[^`\n]*`", "", row).split("|")) for row in table.splitlines()}
        assert len(columns) == 1, table[:200]
        assert re.match(r".*\n *\|[-:|]+\|\n", table), table[:200]


@pytest.mark.parametrize("recipe", re.findall(r"^### (.*)$", CONTRIBUTING, re.MULTILINE))
def test_every_recipe_names_its_test_and_what_is_there(recipe: str) -> None:
    """Tables and constants are in a file that the recipe names."""
    section = CONTRIBUTING.partition(f"### {recipe}\n")[2].partition("\n### ")[0]
    (test,) = re.findall(r"Test: `(tests/\w+/test_\w+\.py)`", section)
    assert (ROOT / test).is_file()
    assert not _missing_constants(section)


def test_small_additions_name_what_is_there() -> None:
    section = CONTRIBUTING.partition("## Small additions\n")[2].partition("\n## ")[0]
    rows = [line for line in section.splitlines() if line.startswith("| a")]
    assert len(rows) == 14
    assert not [name for row in rows for name in _missing_constants(row)]


def _missing_constants(section: str) -> list[str]:
    """Return the constants named in a section that no file named there defines."""
    code = "\n".join((ROOT / name).read_text() for name in set(NAMED.findall(section)) - MADE if name.endswith(".py"))
    constants = re.findall(r"`(_?[A-Z][A-Z_]+)`", section)
    return [name for name in constants if not re.search(rf"^{name}\b", code, re.MULTILINE)]


def test_every_test_of_a_recipe_has_its_recipe() -> None:
    assert all(f"`tests/recipes/{test.name}`" in CONTRIBUTING for test in RECIPES.glob("test_*.py"))


def test_the_snippets_are_those_of_the_tests() -> None:
    code = "\n".join(path.read_text() for path in RECIPES.glob("*.py"))
    snippets = re.findall(r"^    ```python\n(.*?)^    ```$", CONTRIBUTING, re.MULTILINE | re.DOTALL)
    assert len(snippets) == 4
    for snippet in map(textwrap.dedent, snippets):
        row = re.match(r'"\w+": (.*),\n$', snippet, re.DOTALL)
        assert (f"ROW = {row[1]}" if row else snippet) in code


def test_the_architecture_names_every_package() -> None:
    page = (ROOT / "docs/architecture.md").read_text()
    packages = {path.parent.name for path in (ROOT / "wmspec").glob("*/__init__.py")}
    for package in ("lang", "compile", "dataset", "eval"):
        packages |= {f"{package}/{path.parent.name}" for path in (ROOT / "wmspec" / package).glob("*/__init__.py")}
    assert {name for name in packages if f"`wmspec/{name}`" not in page} == set()
