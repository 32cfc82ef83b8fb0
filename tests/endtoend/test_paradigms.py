"""Specs of classic paradigms: each is sound, names its source, is on its page, and keeps its questions."""

from __future__ import annotations

from pathlib import Path

import pytest

import wmspec
from tests.engines import ENGINES, installed

ROOT = Path(__file__).parents[2]
PARADIGMS = sorted((ROOT / "specs/paradigms").glob("*.wms"))
PAGE = (ROOT / "docs/gallery.md").read_text()


@pytest.mark.parametrize("path", PARADIGMS, ids=lambda path: path.stem)
def test_each_is_sound_names_its_source_and_is_on_the_page(path: Path) -> None:
    assert wmspec.diagnose(path).diagnostics == ()
    (task,) = wmspec.load_all(path)
    assert task.name == path.stem
    assert "\nSource: " in path.read_text()
    assert f"`specs/paradigms/{path.name}`" in PAGE
    assert f"images/paradigms/{path.stem}.jpg" in PAGE


def test_each_has_a_picture() -> None:
    pictures = {path.stem for path in (ROOT / "docs/images/paradigms").glob("*.jpg")}
    assert pictures == {path.stem for path in PARADIGMS}


def test_they_are_apart_from_the_catalogue() -> None:
    names = {task.name for task in wmspec.load_all(ROOT / "specs/paradigms")}
    assert len(names) >= 20
    assert not names & {task.name for task in (*wmspec.load_all(), *wmspec.load_all(ROOT / "specs/gallery"))}


@pytest.mark.engine
@pytest.mark.parametrize("name", ["solidity", "permanence_film"])
def test_the_engines_agree_on_possible_and_impossible_episodes(name: str, tmp_path: Path) -> None:
    for engine in ENGINES:
        installed(engine)
    path = ROOT / f"specs/paradigms/{name}.wms"
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
