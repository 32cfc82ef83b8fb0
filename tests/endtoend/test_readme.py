"""The README's first dataset can be made, and all that it names exists."""

import re
import shlex
from pathlib import Path
from typing import Any

import pytest

from tests.command import wmspec as in_this_process
from tests.endtoend.test_commands import COLLIDE, wmspec
from tests.engines import installed
from wmspec.cli import COMMANDS

ROOT = Path(__file__).parents[2]
README = (ROOT / "README.md").read_text()


def block(heading: str, language: str) -> str:
    """The first code block of a language in a section."""
    section = README.partition(f"\n## {heading}\n")[2].partition("\n## ")[0]
    found = re.search(rf"```{language}\n(.*?)```", section, re.DOTALL)
    assert found is not None
    return found[1]


@pytest.mark.engine
def test_the_first_dataset_of_the_readme(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    installed("mujoco")
    pytest.importorskip("datasets")
    commands = block("First dataset", "sh").splitlines()
    for command in commands:
        words = shlex.split(command, comments=True)
        assert words[0] == "wmspec"
        # Small pictures by one worker: the test machine has other work.
        fast = {"generate": ["--size", "64", "-j", "1"], "verify": ["--sample", "1", "-j", "1"]}
        run = wmspec if words[1] == "generate" else in_this_process
        run(*words[1:], *fast.get(words[1], []), folder=tmp_path)
    assert (tmp_path / "gallery.html").is_file()
    assert (tmp_path / "random.parquet").is_file()

    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("HF_HOME", str(tmp_path / "cache"))
    names: dict[str, Any] = {}
    exec(block("First dataset", "python"), names)
    assert names["run"]["ball"].position.shape[1] == 3
    assert names["rows"]
    assert len(names["questions"]) >= 6


def test_the_commands_in_the_table_exist() -> None:
    table = README.partition("| task | command | guide |")[2].partition("\n\n")[0]
    named = {name for row in table.splitlines() for name in re.findall(r"`(\w+)`", row)}
    assert len(named) > 15
    assert named <= set(COMMANDS)


def test_every_link_of_the_readme_leads_to_a_file() -> None:
    links = [link for link in re.findall(r"\]\(([^)]+)\)", README) if "/actions/" not in link]
    assert links
    assert not [link for link in links if not (ROOT / link).exists()]


def test_the_spec_that_the_documentation_shows_is_the_one_that_ships() -> None:
    shown = re.search(r"```wms\n(.*?)```", (ROOT / "docs/tutorial_spec.md").read_text(), re.DOTALL)
    assert shown is not None
    assert shown[1] == COLLIDE.read_text()
