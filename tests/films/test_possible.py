"""Films that are possible or impossible: violation of expectation."""

from __future__ import annotations

import csv
import sys
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pyarrow.parquet as pq
import pytest
from click.testing import CliRunner

from tests.engines import installed
from tests.shared import Shared
from wmspec.api import generate
from wmspec.api.verifying import verify
from wmspec.cli import main
from wmspec.dataset.build.films import read_frames, shown_film
from wmspec.dataset.build.reader import DatasetReader
from wmspec.eval.models.question import Selection, questions

SAME_BALL = Path(__file__).parent / "specs/same_ball.wms"


@pytest.fixture(scope="module")
def whole(shared: Shared) -> Path:
    """A group of four films: a red or blue ball goes behind a screen, and a red or blue one comes out."""
    installed("mujoco")
    options: dict[str, Any] = {"backend": "mujoco", "size": 64, "film": 8, "film_size": (192, 112)}

    def make(folder: Path) -> None:
        generate(SAME_BALL, folder / "out", per_task=4, workers=0, **options)

    return shared.folder("possible films", make) / "out"


def rows_of(dataset: Path) -> list[dict[str, Any]]:
    reader = DatasetReader.open(dataset)
    return [row for task in reader.tasks for row in reader.rows(task)]


def scored(dataset: Path, model: str, output: Path) -> list[dict[str, Any]]:
    result = CliRunner().invoke(main, ["evaluate", str(dataset), "-m", model, "-o", str(output)])
    assert result.exit_code == 0, result.output
    rows: list[dict[str, Any]] = pq.read_table(output).to_pylist()
    return rows


def test_each_film_is_shown_whole_and_split_where_it_may_become_impossible(whole: Path) -> None:
    rows = rows_of(whole)
    assert sorted(row["answer_value"] for row in rows) == ["impossible"] * 2 + ["possible"] * 2
    for row in rows:
        film = shown_film(whole, row)
        assert film is not None
        assert row["option_film"] == []
        assert row["film_context"] == row["film_answer"] + 1 == len(read_frames(whole, row["film"]))
        assert film.text == "Is what the film shows possible?"
        times = film.start + np.arange(film.count) / film.rate
        assert times[row["film_split"] - 1] <= 0.6 + 1e-6 < times[row["film_split"]]


def test_every_beginning_and_every_end_is_as_often_possible_as_not(whole: Path) -> None:
    rows = rows_of(whole)
    films = {row["id"]: read_frames(whole, row["film"]) for row in rows}
    for frame in (0, -1):
        seen: dict[bytes, list[str]] = {}
        for row in rows:
            seen.setdefault(films[row["id"]][frame].tobytes(), []).append(row["answer_value"])
        assert [sorted(answers) for answers in seen.values()] == [["impossible", "possible"]] * 2


def test_models_and_people_judge_the_film(whole: Path) -> None:
    dataset = DatasetReader.open(whole)
    for question in questions(dataset, Selection().ids(dataset)):
        assert question.film is not None
        assert question.film.text.endswith("possible?")
        assert question.options is not None
        assert sorted(word or "" for word in question.options) == ["impossible", "possible"]


def test_films_of_possible_questions_are_verified(whole: Path) -> None:
    assert verify(whole, sample=2, workers=0).verdict == "same"


@pytest.fixture
def model(monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    """Models that remember the colour of the ball, remember it at one moment only, or remember nothing."""
    module = ModuleType("watching")

    def red(frames: Any) -> Any:
        # Of what is neither grey nor brown, the share that is red.
        frames = frames.astype(int)
        return ((frames[..., 0] - frames[..., 2]) > 90).sum(axis=(1, 2)) - ((frames[..., 2] - frames[..., 0]) > 60).sum(
            axis=(1, 2)
        )

    def keen(context: Any, future: Any, fps: int, text: str) -> Any:
        return (np.sign(red(context)[0]) != np.sign(red(future))).astype(float)

    def blind(context: Any, future: Any, fps: int, text: str) -> float:
        return 1.0

    def biased(context: Any, future: Any, fps: int, text: str) -> float:
        return float(future[-1].astype(int)[..., 0].sum())  # more red at the end surprises, whatever came before

    module.keen, module.blind, module.biased = keen, blind, biased  # type: ignore[attr-defined]
    monkeypatch.setitem(sys.modules, "watching", module)
    return module


def test_what_surprises_more_than_the_other_film_is_called_impossible(
    whole: Path, model: ModuleType, tmp_path: Path
) -> None:
    rows = scored(whole, "surprise:watching:keen", tmp_path / "r.parquet")
    assert sorted({row["prompt"] for row in rows}) == ["max", "mean"]
    assert all(row["right"] for row in rows if row["prompt"] == "mean")


def test_a_model_that_knows_nothing_is_not_right(whole: Path, model: ModuleType, tmp_path: Path) -> None:
    rows = scored(whole, "surprise:watching:blind", tmp_path / "r.parquet")
    assert {row["status"] for row in rows} == {"unparsed"}
    biased = scored(whole, "surprise:watching:biased", tmp_path / "q.parquet")
    assert sum(row["right"] for row in biased if row["prompt"] == "mean") == 2


def test_a_table_of_surprises_of_frames(whole: Path, tmp_path: Path) -> None:
    table = tmp_path / "s.csv"
    with table.open("w", newline="") as file:
        out = csv.writer(file)
        out.writerow(["id", "place", "frame", "surprise"])
        for row in rows_of(whole):
            impossible = row["answer_value"] == "impossible"
            # One frame of an impossible film surprises; all the others of it less than those of a possible one.
            out.writerows([row["id"], 0, k, 5.0 if impossible and k == 3 else 1.0 - 0.9 * impossible] for k in range(8))
    rows = scored(whole, f"surprises:{table}", tmp_path / "r.parquet")
    assert all(row["right"] for row in rows if row["prompt"] == "max")
    assert all(row["distances"][0] == 5.0 for row in rows if row["prompt"] == "max" and row["distances"][1] == 1.0)
