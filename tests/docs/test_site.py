"""The documentation builds as a site without a warning, and names all that is public."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

import wmspec
from wmspec.api import HOMES
from wmspec.cli import COMMANDS
from wmspec.dataset.build.columns import COLUMNS
from wmspec.eval.models.results import COLUMNS as RESULTS
from wmspec.runtime.engines.registry import info, names
from wmspec.sim.scene.capability import capability_table

ROOT = Path(__file__).parents[2]


@pytest.mark.build
def test_it_builds_without_warnings(tmp_path: Path) -> None:
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


def test_the_page_of_the_api_names_all_that_is_public() -> None:
    page = (ROOT / "docs/api.md").read_text()
    assert sorted(re.findall(r"heading: wmspec\.(\w+)", page)) == sorted(HOMES)


def test_make_has_the_targets_that_contributors_need() -> None:
    targets = re.findall(r"^([\w-]+):", (ROOT / "Makefile").read_text(), re.MULTILINE)
    reported = re.findall(r"^make ([\w-]+)", (ROOT / "docs/contributing.md").read_text(), re.MULTILINE)
    assert reported
    assert set(reported) <= set(targets)
