"""Films as vision-language models see them: labelled pictures, or a clip in real time."""

from __future__ import annotations

import io
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from wmspec.dataset.build.films import read_frames
from wmspec.dataset.build.reader import DatasetReader
from wmspec.eval.models import prompt
from wmspec.eval.models.question import Question, Selection, questions
from wmspec.eval.models.request import Ask, Clip, Part, Picture, Text


@pytest.fixture(scope="module")
def question(films: Path) -> Question:
    dataset = DatasetReader.open(films)
    return next(iter(questions(dataset, Selection(limit=1).ids(dataset))))


def parts(question: Question, name: str) -> list[Part]:
    """The parts before the words of the question."""
    every = list(Ask(question, prompt.load(name)).request.parts)
    return every[: every.index(Text(question.film.text if question.film else question.text))]


def test_frames_are_those_of_the_film_under_their_times(question: Question) -> None:
    film = question.film
    assert film is not None
    shown = parts(question, "frames")
    frames = read_frames(film.folder, film.path)
    assert len(shown) == 2 * film.count
    for k, (label, picture) in enumerate(zip(shown[::2], shown[1::2], strict=True)):
        assert label == Text(f"Picture {k + 1}, at {film.start + k / film.rate:.2f} s:")
        assert isinstance(picture, Picture)
        assert np.array_equal(np.asarray(Image.open(io.BytesIO(picture.content))), frames[k])


def test_the_question_is_about_the_film(question: Question) -> None:
    film = question.film
    assert film is not None
    ending = "Which picture shows the scene 0.7 seconds after the end of the film?"
    assert film.text in {f"A {tone} ball rolls on a table. {ending}" for tone in ("red", "blue")}
    blind = Ask(question, prompt.load("frames"), ablation="pictures").request.parts
    assert Text(question.text) in blind


def test_of_a_long_film_the_first_and_last_pictures_remain(question: Question, tmp_path: Path) -> None:
    film = question.film
    assert film is not None
    mine = tmp_path / "few.toml"
    mine.write_text('extends = "frames"\nframes = 3\n')
    labels = [part.text for part in parts(question, str(mine)) if isinstance(part, Text)]
    assert len(labels) == 3
    assert labels[0].endswith(f"at {film.start:.2f} s:")
    assert labels[-1].endswith(f"at {film.end:.2f} s:")


def test_pictures_of_other_cameras_stay_beside_the_film(question: Question) -> None:
    film = question.film
    assert film is not None
    seen = replace(question, cameras=("top", *question.cameras[1:]))
    for name, count in (("frames", film.count + 1), ("clip", 1)):
        pictures = [part for part in parts(seen, name) if isinstance(part, Picture)]
        assert len(pictures) == count
        assert pictures[-1].content == question.context[0]


def test_a_clip_lasts_as_long_as_the_film(question: Question) -> None:
    import av

    film = question.film
    assert film is not None
    label, clip = parts(question, "clip")
    assert label == Text(f"A film in real time, from {film.start:.2f} s to {film.end:.2f} s:")
    assert isinstance(clip, Clip)
    with av.open(io.BytesIO(clip.content)) as container:
        times = [frame.time for frame in container.decode(video=0)]
    assert np.allclose(times, np.arange(film.count) / film.rate)


def test_without_a_film_the_pictures_are_labelled_and_a_slow_clip_says_so(question: Question) -> None:
    still = replace(question, film=None)
    labels = [part.text for part in parts(still, "frames") if isinstance(part, Text)]
    times = [f"{time:.2f}" for time in question.times]
    assert labels == [f"Picture {i}, at {time} s:" for i, time in enumerate(times, 1)]
    pytest.importorskip("imageio_ffmpeg")
    label, _ = parts(still, "clip")
    assert label == Text(f"A film of 2 pictures, each shown for 0.5 s. They were taken at {', '.join(times)} s:")


def test_models_get_the_frames_of_a_dataset_with_films(films: Path, tmp_path: Path) -> None:
    import json

    from click.testing import CliRunner

    from wmspec.cli import main

    output = tmp_path / "r.parquet"
    done = CliRunner().invoke(main, ["evaluate", str(films), "-m", "random", "-o", str(output)])
    assert done.exit_code == 0, done.output
    assert json.loads(output.with_suffix(".json").read_text())["asked"]["prompt"] == "frames"
