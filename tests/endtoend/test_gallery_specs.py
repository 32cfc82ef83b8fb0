"""The gallery: specs that show what can be asked. Each is sound, is on its page, and gives questions."""

from __future__ import annotations

from pathlib import Path

import pytest

import wmspec
from tests.engines import installed
from wmspec.api.checking import check_files
from wmspec.lang.parse.files import library_folder

ROOT = Path(__file__).parents[2]
GALLERY = sorted((library_folder().parent / "gallery").glob("*.wms"))
PAGE = (ROOT / "docs/gallery.md").read_text()


@pytest.mark.parametrize("path", GALLERY, ids=lambda path: path.stem)
def test_each_is_sound_has_groups_enough_and_is_on_the_page(path: Path) -> None:
    assert check_files([path]).diagnostics == ()
    tasks = wmspec.load_all(path)
    assert all(task.groups >= 60 for task in tasks)
    assert all(task.name == path.stem or task.name.startswith(f"{path.stem}_") for task in tasks)
    assert f"`specs/gallery/{path.name}`" in PAGE
    assert f"images/gallery/{path.stem}.jpg" in PAGE
    assert (ROOT / f"docs/images/gallery/{path.stem}.jpg").is_file()


def test_the_page_has_no_others() -> None:
    shown = {path.stem for path in (ROOT / "docs/images/gallery").glob("*.jpg")}
    assert shown == {path.stem for path in GALLERY}


def test_gallery_is_separate_from_the_tasks_of_the_paper() -> None:
    catalogue = {task.name for task in wmspec.load_all()}
    gallery = {task.name for task in wmspec.load_all(*GALLERY)}
    assert len(gallery) >= 15
    assert not gallery & catalogue


@pytest.mark.slow
@pytest.mark.engine
@pytest.mark.parametrize("path", GALLERY, ids=lambda path: path.stem)
def test_each_gives_questions(path: Path, tmp_path: Path) -> None:
    installed("mujoco")
    made = wmspec.generate(path, tmp_path / "out", backend="mujoco", per_task=12, size=256, workers=0)
    assert made.rows >= 0.9 * (made.rows + sum(made.rejected.values()))
