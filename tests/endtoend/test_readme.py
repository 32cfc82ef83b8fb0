"""The README shows the spec as it is, and names commands that exist."""

import re
from pathlib import Path

from tests.endtoend.test_commands import COLLIDE
from wmspec.cli import COMMANDS

README = (Path(__file__).parents[2] / "README.md").read_text()


def test_the_spec_in_the_readme_is_the_one_that_ships() -> None:
    shown = re.search(r"```wms\n(.*?)```", README, re.S)
    assert shown is not None
    assert shown[1] == COLLIDE.read_text()


def test_the_commands_of_the_readme_exist() -> None:
    named = set(re.findall(r"^wmspec (\w+)", README, re.M))
    assert named
    assert named <= set(COMMANDS)
