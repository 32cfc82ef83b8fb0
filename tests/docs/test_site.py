"""The documentation builds as a site without a warning, and names all that is public."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from wmspec.api import HOMES
from wmspec.cli import COMMANDS

ROOT = Path(__file__).parents[2]


@pytest.mark.build
def test_it_builds_without_warnings(tmp_path: Path) -> None:
    command = [sys.executable, "-m", "mkdocs", "build", "--strict", "-d", str(tmp_path)]
    environment = os.environ | {"NO_MKDOCS_2_WARNING": "1"}
    done = subprocess.run(command, cwd=ROOT, env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert not re.search("WARNING|ERROR", done.stderr)
    commands = (tmp_path / "commands/index.html").read_text()
    assert all(f"wmspec {name}" in commands for name in COMMANDS)
    reference = (tmp_path / "api/index.html").read_text()
    assert all(f'id="{home}.{name}"' in reference for name, home in HOMES.items())
    assert "freiction" in (tmp_path / "diagnostics/WMS203/index.html").read_text()


def test_the_page_of_the_api_names_all_that_is_public() -> None:
    page = (ROOT / "docs/api.md").read_text()
    assert sorted(re.findall(r"heading: wmspec\.(\w+)", page)) == sorted(HOMES)


def test_make_has_what_contributors_are_told_to_type() -> None:
    targets = re.findall(r"^([\w-]+):", (ROOT / "Makefile").read_text(), re.MULTILINE)
    told = re.findall(r"^make ([\w-]+)", (ROOT / "docs/contributing.md").read_text(), re.MULTILINE)
    assert told
    assert set(told) <= set(targets)
