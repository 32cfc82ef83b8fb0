"""The documentation builds as a site without a warning, and names all that is public."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from functools import cache
from pathlib import Path

import pytest
from markdown.extensions.toc import slugify  # type: ignore[import-untyped]

import wmspec
from tests.language.specs import SPECS
from tools import pages
from wmspec.api import HOMES
from wmspec.cli import COMMANDS
from wmspec.dataset.build.columns import COLUMNS
from wmspec.eval.models.results import COLUMNS as RESULTS
from wmspec.lang.parse.codes import CODES
from wmspec.runtime.engines.registry import info, names
from wmspec.sim.scene.capability import capability_table

ROOT = Path(__file__).parents[2]
#: A link of a page: to another page, to a heading in it, or both.
LINK = re.compile(r"\]\(([^()\s#]*)(?:#([^()\s]+))?\)")
BLOCK = re.compile(r"^( *)(```|~~~).*?^\1\2", re.MULTILINE | re.DOTALL)


@pytest.mark.build
@pytest.mark.slow
def test_it_builds_without_warnings(tmp_path: Path) -> None:
    """The workflow `docs` builds it at every push, too."""
    command = [sys.executable, "-m", "mkdocs", "build", "--strict", "-d", str(tmp_path)]
    environment = os.environ | {"NO_MKDOCS_2_WARNING": "1"}
    done = subprocess.run(command, cwd=ROOT, env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert not re.search("WARNING|ERROR", done.stderr)
    for name in COMMANDS:
        assert f"wmspec {name}" in (tmp_path / f"commands/{name}/index.html").read_text()
    for task in wmspec.load_all():
        card = (tmp_path / f"tasks/{task.name}/index.html").read_text()
        assert all(f"<code>{factor.name}</code>" in card for factor in task.factors)
    columns = (tmp_path / "reference/columns/index.html").read_text()
    assert all(f"<code>{name}</code>" in columns for name in COLUMNS)
    results = (tmp_path / "reference/results/index.html").read_text()
    assert all(f"<code>{name}</code>" in results for name in RESULTS)
    capabilities = (tmp_path / "reference/capabilities/index.html").read_text()
    assert all(name in capabilities for name, _ in capability_table({n: info(n).lacks for n in names()}))
    reference = (tmp_path / "api/index.html").read_text()
    assert all(f'id="{home}.{name}"' in reference for name, home in HOMES.items())
    assert "freiction" in (tmp_path / "diagnostics/WMS203/index.html").read_text()


@pytest.mark.parametrize("page", [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))], ids=lambda p: p.stem)
def test_every_link_leads_somewhere(page: Path) -> None:
    for target, place in LINK.findall(re.sub(r"`[^`\n]*`", "", BLOCK.sub("", page.read_text()))):
        if not re.match(r"\w+:|\.\./\.\./actions/", target):  # elsewhere; workflows of GitHub
            there = Path(os.path.normpath(page.parent / target)) if target else page
            assert there.exists() or there.relative_to(ROOT / "docs").as_posix() in made(), target
            assert not (place and there.suffix == ".md" and there.exists()) or place in places(there), (target, place)


@cache
def made() -> set[str]:
    """The pages that `tools/pages.py` makes."""
    tasks = re.findall(r"^task (\w+)", "\n".join(spec.read_text() for spec in SPECS), re.MULTILINE)
    reference = [f"reference/{name}" for name in ("columns", "results", "capabilities")]
    alone = ("changelog", "commands/index", "tasks/index", *reference)
    every = {"commands": COMMANDS, "diagnostics": CODES, "tasks": tasks}
    return {f"{name}.md" for name in (*alone, *(f"{folder}/{n}" for folder, names in every.items() for n in names))}


@cache
def places(page: Path) -> set[str]:
    """The anchors of a page: its headings as the site writes them, and those that it names itself."""
    text = BLOCK.sub("", page.read_text())
    headings = (re.sub(r"\]\([^)]*\)", "]", heading) for heading in re.findall(r"^#+ (.*)$", text, re.MULTILINE))
    return {slugify(heading, "-") for heading in headings} | set(re.findall(r"(?:\{ ?#|id=\")([\w-]+)", text))


def test_generated_pages_name_all_that_is_public() -> None:
    assert all(f"`{name}`" in pages.columns() for name in COLUMNS)
    assert all(f"`{name}`" in pages.results() for name in RESULTS)
    assert set(pages._commands()) == set(COMMANDS)
    assert all(f"wmspec {name}" in page for name, page in pages._commands().items())


def test_the_page_of_the_api_names_all_that_is_public() -> None:
    page = (ROOT / "docs/api.md").read_text()
    assert sorted(re.findall(r"heading: wmspec\.(\w+)", page)) == sorted(HOMES)


def test_make_has_the_targets_that_contributors_need() -> None:
    targets = re.findall(r"^([\w-]+):", (ROOT / "Makefile").read_text(), re.MULTILINE)
    reported = re.findall(r"^make ([\w-]+)", (ROOT / "docs/contributing.md").read_text(), re.MULTILINE)
    assert reported
    assert set(reported) <= set(targets)
