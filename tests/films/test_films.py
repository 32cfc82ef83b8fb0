"""Films of a dataset: lossless, the same with any number of workers, hashed, verified, sealed and reused."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from hypothesis import given
from hypothesis import strategies as st

from tests.films.conftest import OPTIONS, PAIRS, PUSH, SHOVE
from wmspec.api import generate, load
from wmspec.api.verifying import verify
from wmspec.cli import main
from wmspec.core.diagnostics import WmsError
from wmspec.dataset.build.films import read_ids
from wmspec.dataset.build.reader import DatasetReader
from wmspec.dataset.film.codec import decode, encode, encode_ids
from wmspec.dataset.film.distances import film_distance, mask_points, nearest_pixels, object_points, pairwise
from wmspec.dataset.film.timing import FilmSettings, film_times


def contents(folder: Path) -> dict[str, bytes]:
    return {p.relative_to(folder).as_posix(): p.read_bytes() for p in sorted(folder.rglob("*")) if p.is_file()}


def test_films_and_ids_are_lossless(tmp_path: Path) -> None:
    random = np.random.default_rng(0)
    frames = random.integers(0, 256, (5, 48, 64, 3), dtype=np.uint8)
    ids = random.integers(-1, 700, (5, 48, 64)).astype(np.int16)
    assert (decode(encode(frames, 24)) == frames).all()
    (tmp_path / "0.ids.mkv").write_bytes(encode_ids(ids, 24))
    assert (read_ids(tmp_path, "0.mkv", (64, 48)) == ids).all()
    assert encode(frames, 24) == encode(frames, 24)


@pytest.mark.parametrize("most", [3, 126, 127, 128, 254, 255, 700])
def test_bodies_are_read_at_another_size_as_they_are_decoded(most: int, tmp_path: Path) -> None:
    ids = np.random.default_rng(0).integers(-1, most, (5, 48, 70), endpoint=True).astype(np.int16)
    (tmp_path / "0.ids.mkv").write_bytes(encode_ids(ids, 24))
    assert (read_ids(tmp_path, "0.mkv", (32, 20)) == nearest_pixels(ids, (32, 20))).all()
    assert (read_ids(tmp_path, "0.mkv", (70, 48), 3) == ids[:3]).all()


@given(st.sampled_from([8, 12, 16, 24, 30, 60]), st.floats(0, 2), st.floats(0, 2), st.floats(0.2, 3))
def test_a_film_passes_through_the_last_look(rate: int, start: float, shown: float, later: float) -> None:
    last = start + shown
    times = film_times(start, last, last + later, rate)
    assert times.times[times.context - 1] == pytest.approx(last)
    assert times.times[0] >= start - 1e-5
    assert times.times[0] - start < 1 / rate
    assert times.answer_frame == len(times.times) - 1
    assert -1 / rate < times.offset <= 1e-5
    assert np.allclose(np.diff(times.times), 1 / rate, atol=1e-5)


@pytest.mark.parametrize(("settings", "remedy"), [({"rate": 25}, "8, 12"), ({"rate": 24, "size": (33, 32)}, "832x480")])
def test_settings_have_a_remedy(settings: dict[str, object], remedy: str) -> None:
    with pytest.raises(WmsError) as raised:
        FilmSettings(**settings)  # type: ignore[arg-type]
    assert remedy in str(raised.value.diagnostics[0].help)


def test_distances_are_a_metric() -> None:
    random = np.random.default_rng(0)
    points = [random.uniform(0, 60, (2, 7, 3, 2)) for _ in range(4)]
    apart = pairwise(points, np.array([9.0, 12.0]))
    assert np.allclose(apart, apart.T)
    assert np.allclose(np.diag(apart), 0)
    assert all(apart[i, j] <= apart[i, k] + apart[k, j] + 1e-9 for i in range(4) for j in range(4) for k in range(4))
    absent = np.full((2, 7, 3, 2), np.nan)
    assert film_distance(absent, points[0], np.array([9.0, 12.0])) == 2.0
    assert film_distance(absent, absent, np.array([9.0, 12.0])) == 0.0


@given(st.integers(0, 2**32 - 1), st.floats(0.02, 0.9))
def test_points_of_a_mask_are_its_mean_and_percentiles(seed: int, share: float) -> None:
    mask = np.random.default_rng(seed).random((17, 23)) < share
    ys, xs = np.nonzero(mask)
    points = mask_points(mask)
    if len(xs) < 12:
        assert np.isnan(points).all()
        return
    low, high = np.percentile((xs, ys), (5, 95), axis=1)
    assert np.allclose(points, [(xs.mean(), ys.mean()), low, high], rtol=0, atol=1e-12)


def test_a_row_refers_to_the_films_of_its_options(films: Path) -> None:
    dataset = DatasetReader.open(films)
    rows = [row for row in dataset.rows("shove") if row["film"]]
    assert len(rows) == 8
    for row in rows:
        assert row["option_film"][row["answer"]] == row["film"]
        assert len(set(row["option_film"])) == 4
        apart = np.array(row["film_apart"]).reshape(4, 4)
        assert apart[~np.eye(4, dtype=bool)].min() >= 0.4
        assert row["film_objects"] == ["ball"]
        assert row["film_engines"] == ["pybullet"]
        assert row["film_moving"] >= 2
        assert row["film_text"].startswith("A ")
        assert row["action_text"] in ("It rolls to the left.", "It rolls to the right.")
    others = [row for row in dataset.rows("shove") if not row["film"]]
    assert {row["question_name"] for row in others} == {"where"}
    assert all(row["option_film"] == [] for row in others)


def test_a_film_is_what_the_engine_draws(films: Path) -> None:
    dataset = DatasetReader.open(films)
    row = next(row for row in dataset.rows("shove") if row["film"])
    episode = load(SHOVE)[row["index"]].run("mujoco")
    frames = decode((films / row["film"]).read_bytes())
    last = row["film_start"] + (row["film_context"] - 1) / row["film_rate"]
    assert last == pytest.approx(0.4)
    size = OPTIONS["film_size"]
    ids = read_ids(films, row["film"], size)  # type: ignore[arg-type]
    assert (frames[row["film_context"] - 1] == episode.frame("eye", last, size=size, renderer="mujoco")).all()  # type: ignore[arg-type]
    end = row["film_start"] + row["film_answer"] / row["film_rate"]
    assert (ids[-1] == episode.ids("eye", end, size=size, renderer="mujoco")).all()  # type: ignore[arg-type]
    ball = row["film_bodies"].index("ball")
    points, _ = object_points(ids, [ball])
    track = [(place["across"], place["down"]) for place in row["film_track"]]
    assert np.allclose(points[0, :, 0] / (frames.shape[2], frames.shape[1]), np.array(track, float), atol=0.01)


def test_films_are_reused(films: Path, tmp_path: Path) -> None:
    generate(SHOVE, tmp_path / "whole", per_task=8, workers=0, reuse=[films], **OPTIONS)  # type: ignore[arg-type]
    assert contents(tmp_path / "whole") == contents(films)


def test_lost_film_is_generated_again(pairs: Path, tmp_path: Path) -> None:
    """Its shard is made again in this process, with the hashes of the files that two processes made."""
    folder = tmp_path / "out"
    shutil.copytree(pairs, folder)
    lost, changed = sorted(DatasetReader.open(folder).films)[:2]
    (folder / lost).unlink()
    with pytest.raises(WmsError, match=r"\.mkv is missing"):
        DatasetReader.open(folder).intact()
    generate(PUSH, folder, per_task=4, workers=0, tell=lambda text: None, **PAIRS)  # type: ignore[arg-type]
    assert contents(folder) == contents(pairs)
    (folder / changed).write_bytes(b"")
    with pytest.raises(WmsError, match="was modified"):
        DatasetReader.open(folder).intact()
    (folder / changed).write_bytes((pairs / changed).read_bytes())
    (folder / changed).with_name("999.mkv").write_bytes(b"")
    with pytest.raises(WmsError, match="not part of the dataset"):
        DatasetReader.open(folder).intact()


def test_films_are_verified_and_sealed(pairs: Path, tmp_path: Path) -> None:
    """Verification reports an altered film, also if the manifest has its hash, and no other film or row."""
    folder = tmp_path / "out"
    shutil.copytree(pairs, folder)
    path = sorted(p for p in DatasetReader.open(folder).films if "mujoco" in p and "ids" not in p)[0]
    frames = decode((folder / path).read_bytes())
    frames[3, :40] = 255 - frames[3, :40]
    (folder / path).write_bytes(encode(frames, 8))
    manifest = json.loads((folder / "manifest.json").read_bytes())
    import hashlib

    for shard in manifest["shards"].values():
        shard["films"][path] = hashlib.sha256((folder / path).read_bytes()).hexdigest()
    (folder / "manifest.json").write_text(json.dumps(manifest))
    verified = verify(folder, sample=None, workers=0)
    assert verified.verdict == "different"
    # The card shows a film, and the manifest is written in another form.
    differing = {difference.id for difference in verified.differences}
    assert differing == {path, "examples/push.webp", "manifest.json"}


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["specs/perception/vision/color.wms", "--film", "24"], "closed set"),
        ([str(SHOVE), "--film", "24", "--look", "photo"], "parity"),
        ([str(SHOVE), "--film-size", "64x64"], "set `film` too"),
        ([str(SHOVE), "--film", "24", "--film-size", "65x64"], "even sides"),
    ],
)
def test_impossible_films_are_refused(arguments: list[str], message: str, tmp_path: Path) -> None:
    root = Path(__file__).parents[2]
    arguments = [str(root / a) if a.startswith("specs/") else a for a in arguments]
    result = CliRunner().invoke(main, ["generate", *arguments, "-o", str(tmp_path / "out")])
    assert result.exit_code == 2
    assert message in result.output
