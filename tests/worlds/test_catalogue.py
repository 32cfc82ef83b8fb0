"""Every task of the catalogue is set in three worlds or more, which its groups draw, with things of every day."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

import pytest

import wmspec
from wmspec.lang.parse.files import library_folder

SPECS = library_folder().parent
CATALOGUE = sorted(path for kind in ("perception", "prediction") for path in (SPECS / kind).rglob("*.wms"))
#: What says which of its worlds a library is: a factor or nuisance of its own, or one that a task gives it.
WORLDS = {
    "grounds": "room",
    "tables": "room",
    "places": "place",
    "tabletop_arm": "style",
    "tabletop_arms": "style",
    "town": "weather",
    "apartment": "room",
}
EVERYDAY = ("kitchenware", "food", "toys", "household", "furniture")


def uses(text: str) -> Iterator[str]:
    """The libraries that a spec uses."""
    for found in re.finditer(r"^\s*use (\w+)", text, re.MULTILINE):
        yield found.group(1)


def levels(text: str, name: str) -> int:
    """How many values the factor or nuisance of that name has."""
    listed = re.search(rf"^\s*(?:factor|nuisance)\s+{name}\s+in \[(.*?)\]", text, re.MULTILINE | re.DOTALL)
    return len(listed.group(1).split(",")) if listed else 0


@pytest.mark.parametrize("path", CATALOGUE, ids=lambda path: f"{path.parent.name}/{path.stem}")
def test_a_task_is_set_in_three_worlds_or_more(path: Path) -> None:
    text = path.read_text()
    worlds = [library for library in uses(text) if library in WORLDS]
    assert worlds
    for library in worlds:
        own = (library_folder() / f"{library}.wms").read_text()
        assert max(levels(own, WORLDS[library]), levels(text, WORLDS[library])) >= 3


@pytest.mark.parametrize("name", ["perception/vision/color", "prediction/mechanistic/collide"])
def test_groups_draw_their_world(name: str) -> None:
    """A world is the same within a group, and all of them occur."""
    for task in wmspec.load_all(SPECS / f"{name}.wms"):
        drawn: dict[int, set[object]] = {}
        for instance in task.sample(300):
            values = {**instance.nuisances, **instance.factors}
            (world,) = (values[key] for key in values if key.removeprefix("here_") in ("room", "place"))
            drawn.setdefault(instance.block, set()).add(world)
        assert all(len(worlds) == 1 for worlds in drawn.values())
        assert len({world for worlds in drawn.values() for world in worlds}) == 4


def test_perception_uses_everyday_objects() -> None:
    """Things that are counted, compared, named by colour or located."""
    questions = {path.stem for path in CATALOGUE if set(uses(path.read_text())) & set(EVERYDAY)}
    assert questions >= {"color", "count", "majority", "occupancy", "relation"}
