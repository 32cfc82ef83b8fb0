"""Output before a dataset is made: what there is, what it would cost, and which part is selected."""

import json
from pathlib import Path

import pytest

from tests.command import wmspec
from tests.endtoend.test_commands import COLLIDE, SPECS, SPEED
from tests.engines import installed
from wmspec.api import load_all
from wmspec.api.generating import planned_task
from wmspec.core.wm_abench import COLUMN_OF_TASK, COLUMNS

VISION = SPECS / "perception/vision"


def test_the_numbers_are_the_papers() -> None:
    assert sum(c.cases for c in COLUMNS) == 104_886
    assert len({c.letters for c in COLUMNS}) == 23
    names = [c.name for c in COLUMNS]
    assert len(names) == len(set(names)), "two tasks rebuild the same one"


def test_every_rebuilt_task_has_at_least_the_papers_images_and_cases(tmp_path: Path) -> None:
    rows = {r["task"]: r for r in json.loads(wmspec("list", "--json", folder=tmp_path).stdout)}
    assert set(COLUMN_OF_TASK) <= set(rows), "a task of the table does not ship"
    for name, row in rows.items():
        there = COLUMN_OF_TASK.get(name)
        assert (row["paper"] is None) == (there is None)
        if there is not None:
            assert row["instances"] * row["questions"] >= there.cases, name
            assert row["images"] >= there.images or name.startswith("direction"), name  # see docs/perception.md
    assert "104,886 instances" in " ".join(wmspec("list", folder=tmp_path).stdout.split())


def test_a_dimension_is_chosen_by_its_path(tmp_path: Path) -> None:
    specs = (SPEED, COLLIDE)

    def listed(*dimensions: str) -> set[str]:
        chosen = [part for d in dimensions for part in ("--dimension", d)]
        return {r["task"] for r in json.loads(wmspec("list", "--json", *specs, *chosen, folder=tmp_path).stdout)}

    assert "speed_tabletop" in listed("perception.motion") - listed("prediction")
    assert "collide" in listed("prediction") - listed("perception.motion")
    assert listed("perception", "prediction") <= listed()
    reported = wmspec("list", *specs, "--dimension", "perception.moton", folder=tmp_path, code=2).stderr
    assert "did you mean `perception.motion`?" in reported


def test_a_dry_run_tries_a_few_and_writes_nothing(tmp_path: Path) -> None:
    installed("pybullet")
    dry = ["generate", SPEED, "--dry-run", "-b", "pybullet", "--size", 64, "-j", 1, "--full", "--json"]
    reported = json.loads(wmspec(*dry, folder=tmp_path).stdout)
    assert not list(tmp_path.iterdir())
    (task,) = reported["tasks"]
    assert task["instances"] == 2376
    assert task["tried"] == 24, "four of each of six units"
    assert 0 < task["seconds"] < 300
    assert 0 < task["error"] < task["seconds"], "units differ"
    assert task["hours"] == pytest.approx(task["instances"] * task["seconds"] / 3600)
    assert 1_000 < task["size"] < 1_000_000
    assert task["questions"] == task["tried"]
    assert 0 <= task["rejected"] <= task["tried"]
    assert sum(task["reasons"].values()) == task["rejected"]
    assert task["reasons"].keys() == task["examples"].keys()


def test_tasks_of_the_paper_have_its_size_unless_all_is_requested() -> None:
    def made(name: str, per_task: int | None = None, full: bool = False) -> tuple[int, ...]:
        (task,) = (t for t in load_all(SPEED, VISION / "color.wms") if t.name == name)
        return planned_task(task, per_task, full, (1, 1)).indices

    assert len(made("speed_tabletop")) == 2304
    assert made("speed_tabletop", full=True) == tuple(range(2376))
    assert set(made("speed_tabletop", 50)) < set(made("speed_tabletop"))
    assert 700 < len(made("color_room")) <= 720 < len(made("color_room", full=True)), "two questions each; whole groups"


@pytest.mark.parametrize(
    ("args", "said"),
    [
        (["--full", "--per-task", 3, "-o", "out"], "give one of the two"),
        ([], "missing option --output FOLDER, or --dry-run"),
        (["--dimension", "taste", "-o", "out"], "no task has the dimension `taste`"),
    ],
)
def test_impossible_generation_is_an_error(args: list[object], said: str, tmp_path: Path) -> None:
    assert said in wmspec("generate", SPEED, *args, folder=tmp_path, code=2).stderr
    assert not list(tmp_path.iterdir())
