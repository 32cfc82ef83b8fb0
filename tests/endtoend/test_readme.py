"""The README shows the spec as it is, and names commands that exist."""

import re

from tests.endtoend.test_commands import COLLIDE
from wmspec.cli import COMMANDS
from wmspec.lang.parse.load import library_folder


def readme() -> str:
    root = library_folder().resolve().parent.parent
    return (root / "README.md").read_text()


def test_the_spec_in_the_readme_is_the_one_that_ships() -> None:
    shown = re.search(r"```wms\n(.*?)```", readme(), re.S)
    assert shown is not None
    assert shown[1] == COLLIDE.read_text()


def test_the_commands_of_the_readme_exist() -> None:
    named = set(re.findall(r"^wmspec (\w+)", readme(), re.M))
    assert named
    assert named <= set(COMMANDS)
