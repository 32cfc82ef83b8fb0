"""Every column of a dataset has a description: in its card, its Croissant metadata, and on the page of columns."""

from __future__ import annotations

import re
from dataclasses import replace

import pytest

from tests.language.specs import task_from
from wmspec.compile.design.design import Design
from wmspec.dataset.build.card import card
from wmspec.dataset.build.columns import COLUMNS, FACTOR_COLUMNS, OPTIONAL, description
from wmspec.dataset.build.croissant import croissant
from wmspec.dataset.build.manifest import summary
from wmspec.dataset.build.plan import Plan, Task
from wmspec.dataset.build.rows import schema
from wmspec.dataset.build.shards import Record
from wmspec.dataset.film.timing import FilmSettings

#: A task with every optional column but those of balanced answers.
RICH = """use tabletop
task rich : custom {
  factor tone in [red, blue]
  factor pace in [10 cm/s called "slow", 30 cm/s called "fast"]
  nuisance turn in -6 deg .. 6 deg
  object ball  { shape: sphere  size: 8 cm  color: tone  on: table at (0, 0) }
  object block { shape: cube  size: 8 cm  color: green  on: table at (30 cm, 0)  yaw: turn }
  action go = launch(ball, direction: toward(block), speed: pace)
  horizon 1 s
  observe front at [0 s, 0.2 s] as [rgb, depth, ids]
  question "Which picture shows the end?" {
    answer frame(front, end)
    counterfactual slower { action go.speed: go.speed * 0.5 }
    kinds { moved: displacement(block) > 1 cm  rests: true }
  }
  question "Would it move?" { answer displacement(block) > 1 cm without ball  may hide block }
}
"""
#: A task with balanced answers.
BALANCED = """use tabletop
task balanced : custom {
  factor kind in [sphere, cube]
  factor tone in [red, blue]
  nuisance place in -20 cm .. 20 cm
  design groups of 20 { cross: kind  turn: tone  balance: way }
  object ball { shape: kind  size: 8 cm  color: tone  on: table at (place, 0) }
  observe front at [0 s]
  question way "Is it on the left?" { answer position(ball, at: 0 s).x < 0 m }
}
"""


@pytest.fixture(scope="module")
def plan() -> Plan:
    specs = [task_from(RICH), task_from(BALANCED)]
    return Plan(
        texts={"rich.wms": RICH, "balanced.wms": BALANCED},
        tasks=tuple(Task(spec, Design(spec, 0).sample(4)) for spec in specs),
        engines=("mujoco",),
        size=(64, 64),
        seed=0,
        consensus="all",
        rows_of="questions",
        versions={"wmspec": "0.1.0"},
        shard=4,
        film=FilmSettings(24),
    )


@pytest.fixture(scope="module")
def records(plan: Plan) -> dict[str, Record]:
    return {shard.path: Record("", "0" * 64, 4, ()) for shard in plan.shards()}


@pytest.fixture(scope="module")
def names(plan: Plan) -> set[str]:
    return {name for task in plan.tasks for name in schema(task.spec, films=True).names}


def test_the_tasks_have_every_column(names: set[str]) -> None:
    """So that the tests below cover a group of columns that is added."""
    assert {*COLUMNS, *(name for group in OPTIONAL for name in group.columns)} <= names
    assert {name.partition(".")[0] for name in names if "." in name} == set(FACTOR_COLUMNS)


def test_the_card_describes_every_column(plan: Plan, records: dict[str, Record], names: set[str]) -> None:
    text = card(plan, summary(plan, records), {}).partition("## Columns")[2]
    described = dict(re.findall(r"^\| `([^`]+)` \| (.+) \|$", text, re.MULTILINE))
    assert set(described) == {re.sub(r"\..*", ".*", name) for name in names}
    assert all(described[re.sub(r"\..*", ".*", name)] == description(name).replace("|", "\\|") for name in names)


def test_the_card_names_no_column_that_the_dataset_lacks(plan: Plan, records: dict[str, Record]) -> None:
    only = replace(plan, tasks=plan.tasks[1:], film=None)
    text = card(only, summary(only, records), {}).partition("## Columns")[2]
    assert "`redrawn`" in text
    assert not re.search(r"`(film.*|what_if|context_depth|option_outcome|level\.\*)`", text)


def test_the_metadata_describe_every_column(plan: Plan, records: dict[str, Record]) -> None:
    made = croissant(plan, records, "", "2026-01-01")
    assert len(made["recordSet"]) == 2
    for task, records_ in zip(plan.tasks, made["recordSet"], strict=True):
        described = {field["source"]["extract"]["column"]: field["description"] for field in records_["field"]}
        assert described == {name: description(name) for name in schema(task.spec, films=True).names}


def test_the_page_describes_every_column(names: set[str]) -> None:
    pytest.importorskip("mkdocs")
    from tools import pages

    described = re.findall(r"^\| `([^`]+)` \|.*\w.* \|$", pages.columns(), re.MULTILINE)
    assert set(described) == {re.sub(r"\..*", ".f", name) for name in names}
    assert len(described) == len(set(described))
