"""Films that go on after the answer: for models with a fixed length, and in the layout of Physics-IQ."""

from __future__ import annotations

import csv
from collections import Counter
from pathlib import Path

import av
import pytest
from click.testing import CliRunner

from tests.engines import installed
from tests.films.conftest import OPTIONS, PUSH, SHOVE
from tests.shared import Shared
from wmspec.api import generate
from wmspec.api.verifying import verify
from wmspec.cli import main
from wmspec.dataset.build.films import read_frames
from wmspec.dataset.build.reader import DatasetReader
from wmspec.dataset.film.timing import film_times


def made(shared: Shared, spec: Path, count: int, seconds: float) -> Path:
    """A closed set of `count` futures that go on for some seconds after what is shown."""
    for engine in ("mujoco", "pybullet"):
        installed(engine)

    def make(folder: Path) -> None:
        generate(spec, folder / "out", per_task=count, workers=0, film_for=seconds, **OPTIONS)  # type: ignore[arg-type]

    return shared.folder(f"films of {seconds:g} s", make) / "out"


def test_a_film_goes_on_after_the_answer() -> None:
    times = film_times(0, 0.5, 1, 8, 5)
    assert times.times[-1] == pytest.approx(5.5)
    assert times.times[times.answer_frame] == pytest.approx(1)
    assert film_times(0, 0.5, 3, 8, 1).times == film_times(0, 0.5, 3, 8).times


def test_the_answer_uses_its_span_alone(shared: Shared, tmp_path: Path) -> None:
    longer = made(shared, PUSH, 2, 1)
    dataset = DatasetReader.open(longer)
    row = next(row for row in dataset.rows("push") if row["film"])
    frames = read_frames(longer, row["film"])
    assert len(frames) == row["film_context"] + 8
    assert row["film_answer"] < len(frames) - 1
    assert max(place["frame"] for place in row["film_track"]) == row["film_answer"]
    result = CliRunner().invoke(
        main, ["evaluate", str(longer), "-m", "clips:@engine", "-o", str(tmp_path / "r.parquet")]
    )
    assert "2 replies, 2 right" in result.output, result.output
    assert verify(longer, sample=1, workers=0).verdict == "same"


@pytest.mark.slow
def test_the_layout_of_physics_iq(shared: Shared, tmp_path: Path) -> None:
    longer = made(shared, SHOVE, 4, 5)
    place = tmp_path / "piq"
    result = CliRunner().invoke(main, ["export", str(longer), "--to", "physics-iq", "-o", str(place)])
    assert result.exit_code == 0, result.output
    lines = list(csv.DictReader((place / "descriptions/descriptions.csv").open()))
    assert Counter(line["scenario"].split("_")[2] for line in lines) == {"take-1": 4, "take-2": 4}
    for line in lines:
        # As the programs of Physics-IQ find the files.
        number, view, take, scenario = line["scenario"].split("_")
        testing = place / f"split-videos/testing/8FPS/{number}_testing-videos_8FPS_{view}_{take}_{scenario}"
        masks = place / f"video-masks/real/8FPS/{number}_video-masks_8FPS_{view}_{take}_{scenario}"
        for path in (testing, masks):
            with av.open(str(path)) as container:
                stream = container.streams.video[0]
                assert (sum(1 for _ in container.decode(stream)), stream.average_rate) == (40, 8)
                assert (stream.width, stream.height) == (192, 112)
        assert line["generated_video_name"].split("_")[1:] == [view, scenario]
    assert len(list((place / "switch-frames").iterdir())) == 4


def test_physics_iq_needs_five_seconds(films: Path, tmp_path: Path) -> None:
    result = CliRunner().invoke(main, ["export", str(films), "--to", "physics-iq", "-o", str(tmp_path / "piq")])
    assert result.exit_code == 2
    assert "films of Physics-IQ go on for 5 s after what is shown" in result.output
