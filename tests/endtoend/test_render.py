"""`wmspec render` as a user types it: stills, sheets and films of a spec and of a trace, with names and ways."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

import wmspec as wmspec_api
from tests.command import wmspec
from tests.endtoend.test_commands import COLLIDE
from tests.engines import installed

GIF_TOLERANCE = 60
"""Of 99 pixels in 100. A picture has 255 colours, of a furnished place too; smooth shades come in steps."""


@pytest.fixture(scope="module")
def trace(tmp_path_factory: pytest.TempPathFactory) -> Path:
    installed("pybullet")
    path = tmp_path_factory.mktemp("a trace") / "ball.npz"
    wmspec("run", COLLIDE, "-b", "pybullet", "-o", str(path), folder=path.parent)
    return path


def test_a_trace_is_drawn_as_its_spec_is(trace: Path) -> None:
    folder = trace.parent
    wmspec("render", str(trace), "--size", "64", "-o", "of trace", folder=folder)
    wmspec("render", COLLIDE, "-b", "pybullet", "--size", "64", "-o", "of spec", folder=folder)
    pairs = list(zip(sorted((folder / "of trace").iterdir()), sorted((folder / "of spec").iterdir()), strict=True))
    assert len(pairs) == 3
    for one, other in pairs:
        assert one.read_bytes() == other.read_bytes()


def test_a_sheet_has_a_picture_for_every_look(trace: Path) -> None:
    wmspec("render", str(trace), "--size", "64", "-o", "sheet.png", folder=trace.parent)
    sheet = Image.open(trace.parent / "sheet.png")
    assert sheet.width > 3 * 64
    wmspec("render", str(trace), "--size", "64", "--camera", "front", "-o", "front.png", folder=trace.parent)
    assert Image.open(trace.parent / "front.png").size == sheet.size


def test_an_overlay_draws_names_and_ways(trace: Path) -> None:
    wmspec("render", str(trace), "--size", "96", "-o", "bare", folder=trace.parent)
    wmspec("render", str(trace), "--size", "96", "--overlay", "-o", "named", folder=trace.parent)
    names = sorted(path.name for path in (trace.parent / "bare").iterdir())
    bare, named = (
        [np.asarray(Image.open(trace.parent / folder / name)).astype(int) for name in names]
        for folder in ("bare", "named")
    )
    written = [np.abs(one - other).max(axis=2) > 40 for one, other in zip(bare, named, strict=True)]
    assert written[0].sum() > 40, "names"
    assert (written[-1] & ~written[0]).sum() > 20, "a way of the ball"


def test_a_gif_shows_the_whole_episode(trace: Path) -> None:
    wmspec("render", str(trace), "--size", "64", "--rate", "10", "-o", "film.gif", folder=trace.parent)
    film = Image.open(trace.parent / "film.gif")
    total = 0
    begins = []  # pictures that are alike are one
    for i in range(getattr(film, "n_frames", 1)):
        film.seek(i)
        begins.append(total)
        total += film.info["duration"]
    last = wmspec_api.load_episode(trace).time[-1]
    assert total == 100 * (int(10 * last) + 1), "10 pictures a second, from 0 s on; the last as long as the others"
    wmspec("render", str(trace), "--size", "64", "-o", "stills", folder=trace.parent)
    still = np.asarray(Image.open(min((trace.parent / "stills").iterdir()))).astype(int)
    film.seek(sum(begin <= 500 for begin in begins) - 1)  # at 0.5 s, as the first still
    apart = np.abs(np.asarray(film.convert("RGB")).astype(int) - still).max(axis=2)
    assert np.quantile(apart, 0.99) < GIF_TOLERANCE
    first = (trace.parent / "film.gif").read_bytes()
    wmspec("render", str(trace), "--size", "64", "--rate", "10", "-o", "film.gif", folder=trace.parent)
    assert (trace.parent / "film.gif").read_bytes() == first


def test_an_mp4_shows_the_whole_episode(trace: Path) -> None:
    ffmpeg = pytest.importorskip("imageio_ffmpeg")
    wmspec("render", str(trace), "--size", "64", "-o", "film.mp4", folder=trace.parent)
    frames = ffmpeg.read_frames(str(trace.parent / "film.mp4"))
    about = next(frames)
    assert about["size"] == (64, 64)
    last = wmspec_api.load_episode(trace).time[-1]
    assert len(list(frames)) == int(25 * last) + 1, "25 pictures a second, from 0 s on"


def test_an_mp4_without_its_package_is_refused_with_the_remedy(trace: Path) -> None:
    command = f"""
import sys; sys.modules["imageio_ffmpeg"] = None
from wmspec.cli import main
sys.argv = ["wmspec", "render", {str(trace)!r}, "--size", "64", "-o", "no.mp4"]
main()
"""
    done = subprocess.run(
        [sys.executable, "-c", command], cwd=trace.parent, capture_output=True, text=True, check=False
    )
    assert done.returncode == 2
    assert "wmspec[video]" in done.stderr
    assert "Traceback" not in done.stderr


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--look", "beauty", "-o", "x"], "'photo'"),
        (["--samples", "4", "-o", "x"], "--look photo"),
        (["--camera", "nowhere", "-o", "x"], "no camera `nowhere`"),
        (["-o", "x.bmp"], ".png, .gif or .mp4"),
    ],
)
def test_mistakes_are_explained(arguments: list[str], message: str, trace: Path) -> None:
    assert message in wmspec("render", trace, *arguments, folder=trace.parent, code=2).stderr


def test_another_file_is_no_trace(tmp_path: Path) -> None:
    (tmp_path / "no.npz").write_text("nothing")
    np.savez(tmp_path / "other.npz", x=np.zeros(3))
    for name in ("no.npz", "other.npz", "lost.npz"):
        assert name in wmspec("render", name, "-o", "x", folder=tmp_path, code=2).stderr
