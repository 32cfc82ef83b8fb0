"""The profile wm-abench: the paper's columns, its numbers of pictures and its chance levels."""

from __future__ import annotations

from pathlib import Path

import pytest

import wmspec
from tests.engines import installed
from wmspec.api.checking import check_files
from wmspec.api.generating import plan_dataset
from wmspec.api.profile import with_profile
from wmspec.api.verifying import verify
from wmspec.core.diagnostics import WmsError
from wmspec.core.wm_abench import COLUMNS
from wmspec.dataset.build.reader import DatasetReader
from wmspec.lang.check.ir.ir import Items
from wmspec.lang.parse.files import catalogue_folders

#: Chance levels of the paper that are not 25 %: its tables of results, row Random.
OPTIONS = {"SE-V": 2, "SE-O": 2, "V-M": 2, "CQ": 2, "TP": 3, "TE": 3, "MS": 3, "RQ": 3}


@pytest.fixture(scope="module")
def tasks() -> tuple[wmspec.Task, ...]:
    """Checked first: the check stores all that later tests load, while loading stores the tasks only."""
    assert check_files(catalogue_folders()).passed
    return with_profile(wmspec.load_all(*catalogue_folders()), "wm-abench")


def test_it_has_every_column_in_the_papers_order(tasks: tuple[wmspec.Task, ...]) -> None:
    assert tuple(task.paper for task in tasks) == COLUMNS


def test_every_task_asks_one_question_with_the_papers_number_of_pictures(tasks: tuple[wmspec.Task, ...]) -> None:
    for task in tasks:
        (question,) = task.spec.questions
        words = "".join(part for part in question.text if isinstance(part, str))
        assert task.paper
        assert task.images == task.paper.images or "picture" in words, task.name


def test_every_task_has_the_papers_chance_level(tasks: tuple[wmspec.Task, ...]) -> None:
    for task in tasks:
        options = task.spec.questions[0].options
        if isinstance(options, Items) and task.paper:
            assert len(options.items) == OPTIONS.get(task.paper.letters, 4), task.name


def test_a_dataset_of_a_profile_verifies(tmp_path: Path) -> None:
    installed("mujoco")
    spec = next(path for folder in catalogue_folders() for path in folder.rglob("color.wms"))
    made = tmp_path / "out"
    wmspec.generate(spec, made, profile="wm-abench", backend="mujoco", per_task=2, size=64, workers=0)
    dataset = DatasetReader.open(made)
    assert dataset.manifest["profile"] == "wm-abench"
    assert {row["question_name"] for task in dataset.tasks for row in dataset.rows(task)} == {"which"}
    assert verify(made, workers=0).verdict == "same"


def test_other_specs_and_names_are_refused() -> None:
    gallery = Path(__file__).parents[2] / "specs/gallery/cradle.wms"
    with pytest.raises(WmsError, match="none of the tasks rebuilds a column"):
        plan_dataset(gallery, profile="wm-abench")
    with pytest.raises(WmsError, match="no profile"):
        plan_dataset(gallery, profile="abench")  # type: ignore[arg-type]
