"""What cars and walkers do is checked, listed and refused where it would have to be executed, with its place."""

import json
import re
from pathlib import Path

import pytest
from click.testing import CliRunner

from tests.language.specs import SPECS, task_of
from wmspec.cli import main
from wmspec.design.design import Design
from wmspec.diagnostics import WmsError
from wmspec.robots.plan import ARMS
from wmspec.stage.agents import without
from wmspec.stage.episode import document


def acts(path: Path) -> list[str]:
    """What cars and walkers do in a spec."""
    spec = task_of(path)
    return [t.name for t in spec.things if t.kind == "action" and t.of and spec.thing(t.of).model not in ARMS]


@pytest.mark.parametrize("path", SPECS, ids=lambda p: f"{p.parent.stem}-{p.stem}")
def test_what_robots_do_is_refused_with_its_place_and_the_rest_is_staged(path: Path) -> None:
    spec = task_of(path)
    instance = Design(spec)[0]
    if acts(path):
        with pytest.raises(WmsError, match="cannot be executed yet") as caught:
            document(spec, instance)
        file, line = re.match(r"(.+):(\d+):\d+: ", str(caught.value)).groups()  # type: ignore[union-attr]
        assert f"action {acts(path)[0]}" in Path(file).read_text().splitlines()[int(line) - 1]
    prims = document(without(spec), instance).prims
    actions = [t.name for t in spec.things if t.kind == "action"]
    assert [a for a in actions if f"/World/Episode/Actions/{a}" not in prims] == acts(path)


def test_they_are_listed_as_such() -> None:
    listed = json.loads(CliRunner().invoke(main, ["list", "--json"]).stdout)
    assert {row["file"] for row in listed if not row["executable"]} == {str(path) for path in SPECS if acts(path)}
    assert "arm_push *" not in CliRunner().invoke(main, ["list"]).stdout


def test_there_are_tasks_of_both_sorts() -> None:
    assert {bool(acts(path)) for path in SPECS} == {True, False}
