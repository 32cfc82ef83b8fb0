"""Specs of classic paradigms: each is sound, names its source, is on its page, and keeps its questions."""

from __future__ import annotations

from pathlib import Path

import pytest

import wmspec
from tests.engines import ENGINES, installed
from wmspec.api.checking import check_files
from wmspec.dataset.audit.duplicates import MIN_GROUPS
from wmspec.lang.parse.files import library_folder

ROOT = Path(__file__).parents[2]
PARADIGMS = sorted((library_folder().parent / "paradigms").glob("*.wms"))
PAGE = (ROOT / "docs/gallery.md").read_text()


@pytest.mark.parametrize("path", PARADIGMS, ids=lambda path: path.stem)
def test_each_names_its_source_and_is_on_the_page(path: Path) -> None:
    text = path.read_text()
    assert "\nSource: " in text
    assert f"\ntask {path.stem} : " in text
    assert f"`specs/paradigms/{path.name}`" in PAGE
    assert f"images/paradigms/{path.stem}.jpg" in PAGE


@pytest.mark.parametrize("path", PARADIGMS, ids=lambda path: path.stem)
def test_each_is_sound_and_has_enough_groups_for_an_audit(path: Path) -> None:
    assert check_files([path]).diagnostics == ()
    (task,) = wmspec.load_all(path)
    assert task.name == path.stem
    assert task.groups >= MIN_GROUPS


def test_each_has_a_picture() -> None:
    pictures = {path.stem for path in (ROOT / "docs/images/paradigms").glob("*.jpg")}
    assert pictures == {path.stem for path in PARADIGMS}


def test_gallery_is_separate_from_the_catalogue() -> None:
    names = {path.stem for path in PARADIGMS}
    assert len(names) >= 20
    assert not names & {path.stem for folder in ("perception", "prediction", "gallery") for path in others(folder)}


def others(folder: str) -> list[Path]:
    """The other specs of a folder."""
    return sorted((ROOT / "specs" / folder).rglob("*.wms"))


@pytest.mark.engine
def test_the_engines_agree_on_possible_and_impossible_episodes(tmp_path: Path) -> None:
    for engine in ENGINES:
        installed(engine)
    (path,) = (path for path in PARADIGMS if path.stem == "permanence_film")
    made = wmspec.generate(path, tmp_path / "out", backend="all", per_task=4, size=256, workers=0)
    assert (made.rows, sum(made.rejected.values())) == (4, 0)


@pytest.mark.slow
@pytest.mark.engine
@pytest.mark.parametrize("path", PARADIGMS, ids=lambda path: path.stem)
def test_each_keeps_its_questions(path: Path, tmp_path: Path) -> None:
    for engine in ENGINES:
        installed(engine)
    made = wmspec.generate(path, tmp_path / "out", backend="all", per_task=12, size=256, workers=0)
    assert made.rows >= 0.9 * (made.rows + sum(made.rejected.values()))
