"""Clips: damaged futures are recognized, and what is no future is not taken for one."""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow.parquet as pq
import pytest
from click.testing import CliRunner
from hypothesis import given
from hypothesis.extra.numpy import arrays

from tests.films.corrupt import KEEPS, SPOILS, Original, clip
from wmspec.cli import main
from wmspec.dataset.build.films import read_frames
from wmspec.dataset.build.reader import DatasetReader
from wmspec.dataset.film.codec import encode, encode_mp4
from wmspec.dataset.film.distances import end_distance, film_distance
from wmspec.eval.clips import run as run_module
from wmspec.eval.clips.decide import decide
from wmspec.eval.clips.measure import Measurement, measure
from wmspec.eval.clips.pixels import count, overlaps, packed
from wmspec.eval.clips.questions import FilmQuestion, film_questions, reference_of
from wmspec.eval.clips.reference import Reference
from wmspec.eval.clips.run import ClipRun, evaluate_clips, rescore_clips
from wmspec.eval.models.causes import causes
from wmspec.eval.models.question import Selection


@pytest.fixture(scope="module")
def dataset(films: Path) -> DatasetReader:
    return DatasetReader.open(films)


@pytest.fixture(scope="module")
def questions(dataset: DatasetReader) -> list[FilmQuestion]:
    return list(film_questions(dataset, Selection().ids(dataset)))


@pytest.fixture(scope="module")
def reference(dataset: DatasetReader, questions: list[FilmQuestion]) -> Reference:
    return reference_of(dataset, questions[0])


def run(dataset: DatasetReader, place: str, output: Path) -> list[dict[str, Any]]:
    evaluate_clips(ClipRun(dataset, place, Selection()), output, lambda right, count: None)
    rows: list[dict[str, Any]] = pq.read_table(output).to_pylist()
    return rows


def folder_of(dataset: DatasetReader, questions: list[FilmQuestion], folder: Path, which: Any) -> Path:
    """Clips of a model that answers each question with the film of the option `which(question)`."""
    folder.mkdir(parents=True)
    for question in questions:
        frames = read_frames(dataset.folder, question.films[which(question)])
        (folder / f"{question.file_name}.mp4").write_bytes(
            encode_mp4(frames[question.context - 1 :], question.rate, 20)
        )
    return folder


# ---------------------------------------------------------------- decisions


@pytest.mark.parametrize("damage", KEEPS)
def test_a_damaged_future_is_recognized(damage: str, reference: Reference) -> None:
    for option in range(4):
        measured = measure(KEEPS[damage](Original(reference, option)), reference, option)
        assert decide(measured, reference.rate).choice == option


@pytest.mark.parametrize("damage", SPOILS)
def test_spoiled_clip_is_no_future(damage: str, reference: Reference) -> None:
    for option in range(4):
        decision = decide(measure(SPOILS[damage](Original(reference, option)), reference, option), reference.rate)
        assert decision.choice is None
        assert decision.why


def test_the_order_of_the_options_changes_nothing_but_the_place(reference: Reference) -> None:
    other = Reference(reference.rate, reference.films[::-1], reference.objects)
    original = KEEPS["blur"](Original(reference, 1))
    here, there = measure(original, reference, 1), measure(original, other, 2)
    a, b = decide(here, reference.rate), decide(there, reference.rate)
    assert (a.choice, b.choice) == (1, 2)
    assert np.allclose(a.distances, b.distances[::-1], atol=0.05)


@pytest.mark.parametrize("begins", ["context", "first", "after"])
def test_start_of_a_clip_is_found(begins: str, reference: Reference) -> None:
    film = reference.films[2]
    start = {"context": 0, "first": film.context - 1, "after": film.context}[begins]
    measured = measure(clip(film.frames[start:], reference.rate), reference, 2)
    assert measured.begins == begins
    assert decide(measured, reference.rate).choice == 2


def test_short_clip_matches_no_future(reference: Reference) -> None:
    frames = Original(reference, 0).frames
    decision = decide(measure(clip(frames[: len(frames) // 2], reference.rate), reference, 0), reference.rate)
    assert decision.choice is None
    assert "short" in decision.why


@given(arrays(bool, (2, 3, 7, 11)), arrays(bool, (2, 3, 7, 11)))
def test_overlaps_of_packed_masks(a: Any, b: Any) -> None:
    both, either = (a & b).sum(axis=(2, 3)), (a | b).sum(axis=(2, 3))
    assert (count(packed(a)) == a.sum(axis=(2, 3))).all()
    assert (overlaps(packed(a), packed(b)) == np.where(either == 0, 1, both / np.maximum(either, 1))).all()


# ---------------------------------------------------------------- runs


@pytest.mark.parametrize("name", ["oracle", "engine"])
def test_true_futures_are_right(name: str, dataset: DatasetReader, tmp_path: Path) -> None:
    rows = run(dataset, f"@{name}", tmp_path / "r.parquet")
    assert len(rows) == 8
    assert all(row["right"] for row in rows)


@pytest.mark.parametrize("name", ["frozen", "blend"])
def test_baselines_without_a_future_answer_nothing(name: str, dataset: DatasetReader, tmp_path: Path) -> None:
    rows = run(dataset, f"@{name}", tmp_path / "r.parquet")
    assert {row["status"] for row in rows} == {"unparsed"}


def test_model_that_ignores_the_state_predicts_the_sibling(
    dataset: DatasetReader, questions: list[FilmQuestion], tmp_path: Path
) -> None:
    rows = {
        row["id"]: row for task in dataset.tasks for row in dataset.rows(task, ["id", "option_kind", "factor.start"])
    }

    def sibling(question: FilmQuestion) -> int:
        """The film of the option that differs in the state alone, for half of the states."""
        ignores = rows[question.id]["factor.start"] > 0
        return rows[question.id]["option_kind"].index("state") if ignores else question.answer

    place = folder_of(dataset, questions, tmp_path / "clips", sibling)
    scored = run(dataset, str(place), tmp_path / "r.parquet")
    assert sum(row["right"] for row in scored) == len(scored) / 2
    wrong = [row for row in scored if not row["right"]]
    assert {rows[row["id"]]["option_kind"][row["parsed"]] for row in wrong} == {"state"}


def test_rates_names_and_answers_do_not_matter(
    dataset: DatasetReader, questions: list[FilmQuestion], tmp_path: Path
) -> None:
    question = questions[0]
    place = tmp_path / "clips"
    place.mkdir()
    frames = read_frames(dataset.folder, question.film)[question.context - 1 :]
    (place / f"{question.file_name}.0.mp4").write_bytes(encode_mp4(frames, question.rate))
    (place / f"{question.file_name}.1.mkv").write_bytes(encode(frames, question.rate))
    (place / f"{question.file_name}.2.mp4").write_bytes(encode_mp4(np.repeat(frames, 3, axis=0), 3 * question.rate))
    rows = [row for row in run(dataset, str(place), tmp_path / "r.parquet") if row["id"] == question.id]
    assert [row["sample"] for row in rows] == [0, 1, 2]
    assert {row["parsed"] for row in rows} == {question.answer}


def test_broken_files_cost_their_clip_only(
    dataset: DatasetReader, questions: list[FilmQuestion], tmp_path: Path
) -> None:
    place = folder_of(dataset, questions, tmp_path / "clips", lambda question: question.answer)
    paths = [place / f"{question.file_name}.mp4" for question in questions]
    paths[0].write_bytes(b"no film")
    paths[1].write_bytes(paths[1].read_bytes()[:300])
    paths[2].unlink()
    paths[3].unlink()
    paths[3].symlink_to("/etc/passwd")
    frames = read_frames(dataset.folder, questions[4].film)
    paths[4].write_bytes(encode_mp4(frames[:1], questions[4].rate))
    with paths[5].open("wb") as file:
        file.truncate(10 << 30)
    rows = {row["id"]: row for row in run(dataset, str(place), tmp_path / "r.parquet")}
    for question in questions[:6]:
        assert rows[question.id]["status"] == "error"
        assert rows[question.id]["error"]
    assert all(rows[question.id]["right"] for question in questions[6:])


def test_films_of_questions_without_clips_are_not_read(
    dataset: DatasetReader, questions: list[FilmQuestion], tmp_path: Path
) -> None:
    answered = [question for question in questions if question.block == questions[0].block]
    place = folder_of(dataset, answered, tmp_path / "clips", lambda question: question.answer)
    without = tmp_path / "without"
    shutil.copytree(dataset.folder, without)
    for question in questions:
        if question not in answered:
            (without / question.film).unlink()
    rows = {row["id"]: row for row in run(DatasetReader.open(without), str(place), tmp_path / "r.parquet")}
    assert len(answered) < len(questions) == len(rows)
    for question in questions:
        row = rows[question.id]
        expected = "there is no clip of this question"
        assert row["right"] if question in answered else row["error"] == expected


def test_scores_come_again_from_the_measurements(
    dataset: DatasetReader, questions: list[FilmQuestion], tmp_path: Path
) -> None:
    place = folder_of(dataset, questions, tmp_path / "clips", lambda question: question.answer)
    output = tmp_path / "r.parquet"
    before = run(dataset, str(place), output)
    shutil.rmtree(place)
    counts = rescore_clips(output)
    assert counts is not None
    assert counts[1] == 0
    assert pq.read_table(output).to_pylist() == before


def test_a_run_that_was_cut_off_goes_on(
    dataset: DatasetReader, questions: list[FilmQuestion], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The second run measures what the first has not, and a clip that changed between them; the results are equal."""
    place = folder_of(dataset, questions, tmp_path / "clips", lambda question: question.own)
    changed, whole, output = run_module.by_set(questions)[0], tmp_path / "whole" / "r.parquet", tmp_path / "r.parquet"
    begun: list[str] = []
    monkeypatch.setattr(run_module, "measure", lambda *given: begun.append("") or measure(*given))

    def stop(right: int, count: int) -> None:
        if count == 3:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        evaluate_clips(ClipRun(dataset, str(place), Selection()), output, stop)
    begun.clear()
    shutil.copy(place / f"{questions[-1].file_name}.mp4", place / f"{changed.file_name}.mp4")
    rows = run(dataset, str(place), output)
    assert len(begun) == len(questions) - 2
    assert [path.name for path in tmp_path.iterdir() if path.name.endswith(".clips")] == []
    whole.parent.mkdir()
    assert run(dataset, str(place), whole) == rows


# ---------------------------------------------------------------- what comes out late


def track(hidden: range, turns: bool, frames: int = 28) -> Any:
    """The points (1, T, 3, 2) of an object that rolls to the right, is hidden for some frames, and may turn back."""
    x = 4.0 * np.arange(frames)
    if turns:
        x = np.minimum(x, 4.0 * (hidden.start + len(hidden) // 2) * 2 - x)
    points = np.repeat(np.stack([x, np.zeros(frames)], axis=-1)[:, None], 3, axis=1)[None]
    points[:, list(hidden)] = np.nan
    return points


def of_two(futures: Any, clip: Any) -> Measurement:
    """The measurement of a clip that pixels take for the first of two futures."""
    (one, other), width = futures, np.array([8.0])
    apart = film_distance(one, other, width), end_distance(one, other, width)
    away = np.array([[0.0, 1.0], [1.0, 0.0]])
    return Measurement(
        points=np.stack([clip, clip]),
        areas=np.full((1, clip.shape[1]), 64.0),
        futures=np.stack(futures),
        apart=np.stack([away * each for each in apart]),
        widths=width,
        votes=np.array([[0.1, 1.0]] * 3),
        left_empty=np.ones(2),
        vacancies=away,
        physics_iq=np.ones((2, 4)),
        overlap=np.ones(2),
        background_rmse=0.0,
        zoom=1.0,
        inliers=1.0,
        short=0.0,
        fit="stretch",
        begins="first",
    )


@pytest.mark.parametrize("out", [20, 22, 24, 25, 26, 27])
def test_a_clip_in_which_nothing_comes_out_is_not_a_future_in_which_it_comes_out_late(out: int) -> None:
    """At a slower tempo the object would still be hidden at the end, but then the clip does not show what happens."""
    futures = track(range(6, out), turns=False), track(range(6, 12), turns=True)
    gone = track(range(6, 28), turns=False)
    assert decide(of_two(futures, futures[0]), 24).choice == 0
    assert decide(of_two(futures, gone), 24).choice is None


# ---------------------------------------------------------------- the whole way of a user


def test_from_the_exported_folder_to_a_report(films: Path, dataset: DatasetReader, tmp_path: Path) -> None:
    """A stand-in for a model knows the exported folder alone, and returns for each prompt a still picture."""
    import csv

    exported, clips = tmp_path / "in", tmp_path / "clips"
    made = CliRunner().invoke(main, ["export", str(films), "--to", "video", "-o", str(exported)])
    assert made.exit_code == 0, made.output
    clips.mkdir()
    lines = list(csv.DictReader((exported / "prompts.csv").open()))
    assert len(lines) == 8
    for line in lines:
        from PIL import Image

        first = np.asarray(Image.open(exported / line["first"]))
        assert first.shape == (int(line["height"]), int(line["width"]), 3)
        frames = np.repeat(first[None], int(line["frames"]) + 1, axis=0)
        (clips / line["clip"]).write_bytes(encode_mp4(frames, int(line["fps"])))
    (clips / "model.json").write_text('{"name": "still", "version": "1"}')
    results = tmp_path / "still.parquet"
    scored = CliRunner().invoke(main, ["evaluate", str(films), "-m", f"clips:{clips}", "-o", str(results)])
    assert scored.exit_code == 0, scored.output
    assert "8 unparsed" in scored.output
    rows = pq.read_table(results).to_pylist()
    assert {(row["model"], row["model_version"]) for row in rows} == {("clips:still", "still 1")}
    assert all(cause.cause.startswith("none of the futures: ") and not cause.example for cause in causes(rows))
    assert sum(cause.count for cause in causes(rows)) == 8


def test_the_exported_folder_does_not_hold_the_future(films: Path, dataset: DatasetReader, tmp_path: Path) -> None:
    exported = tmp_path / "in"
    CliRunner().invoke(main, ["export", str(films), "--to", "video", "-o", str(exported), "--frames"])
    rows = {row["id"]: row for task in dataset.tasks for row in dataset.rows(task)}
    text = "".join(
        path.read_text() for path in (exported / "prompts.csv", exported / "export.json", exported / "README.md")
    )
    for row in rows.values():
        for path in row["option_film"]:
            assert path not in text
    shown = {path.read_bytes() for path in exported.rglob("*.png")}
    for row in (row for row in rows.values() if row["film"]):
        frames = read_frames(dataset.folder, row["film"])
        assert len(list((exported / "frames" / row["id"].replace("/", "-")).iterdir())) == row["film_context"]
        assert frames[-1].tobytes() not in shown
