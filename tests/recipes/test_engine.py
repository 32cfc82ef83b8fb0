"""The recipe "adding an engine": a distribution of its own, found by its entry point, goes the way of every engine."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import wmspec as package
from tests.engines import ENGINES, installed
from wmspec.runtime.engines.registry import select_backends

HERE = Path(__file__).parent
HOME = Path(package.__file__).parents[1]
FLIGHT = HERE / "flight.wms"
MEETING = HERE.parent / "crosscheck/race.wms"


class Wmspec:
    """The command line where the toy engine is installed."""

    def __init__(self, site: Path) -> None:
        self.environment = {**os.environ, "PYTHONPATH": os.pathsep.join([str(site), str(HOME)])}

    def __call__(self, *arguments: str | Path, code: int = 0) -> subprocess.CompletedProcess[str]:
        command = [sys.executable, "-m", "wmspec", *map(str, arguments)]
        done = subprocess.run(command, env=self.environment, capture_output=True, text=True, check=False)
        assert done.returncode == code, done.stdout + done.stderr
        assert "Traceback" not in done.stderr
        return done

    def json(self, *arguments: str | Path) -> Any:
        return json.loads(self(*arguments, "--json").stdout)


@pytest.fixture(scope="module")
def wmspec(tmp_path_factory: pytest.TempPathFactory) -> Wmspec:
    site = tmp_path_factory.mktemp("site")
    pip = [sys.executable, "-m", "pip", "install", "-q", "--no-deps", "--no-build-isolation", "--no-index"]
    done = subprocess.run([*pip, "--target", site, HERE / "toy"], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return Wmspec(site)


def test_it_executes(wmspec: Wmspec, tmp_path: Path) -> None:
    (trace,) = wmspec.json("run", FLIGHT, "--backend", "toy", "-o", tmp_path / "trace.npz")
    assert trace["engine"] == "toy"
    kept = np.load(tmp_path / "trace.npz")
    ball = list(kept["bodies"]).index("left")
    speed = (kept["position"][-1, ball, 0] - kept["position"][0, ball, 0]) / kept["time"][-1] / np.cos(np.pi / 3)
    assert speed == pytest.approx(min((0.4, 0.6, 0.8), key=lambda known: abs(known - speed)))
    time, height = kept["time"], kept["position"][:, ball, 2]
    np.testing.assert_allclose(height, 0.5 + speed * np.sin(np.pi / 3) * time - 9.81 * time**2 / 2, atol=1e-6)


def test_it_draws(wmspec: Wmspec, tmp_path: Path) -> None:
    from PIL import Image

    wmspec("render", FLIGHT, "--backend", "toy", "--size", "96", "-o", tmp_path)
    pictures = [np.asarray(Image.open(path), int) for path in sorted(tmp_path.glob("*.png"))]
    red = [(p[..., 0] - p[..., 1:].max(axis=-1) > 60).nonzero()[0].mean() for p in pictures]
    assert red[0] < red[1], "the red ball is lower in the later picture"


def test_doctor_tests_the_engine(wmspec: Wmspec) -> None:
    well = {f["name"] for f in wmspec.json("doctor")["findings"] if f["ok"]}
    assert {"toy", "toy executes", "toy renders"} <= well
    lacking = {row["capability"]: row["lacking"].get("toy") for row in wmspec.json("doctor", "--capabilities")}
    assert "Toy knows free bodies only; remove the joint" in lacking.values()


def test_crosscheck_uses_the_new_engine(wmspec: Wmspec, tmp_path: Path) -> None:
    others = select_backends("all")
    backends = ",".join(("toy", *others))
    wmspec("crosscheck", FLIGHT, "--backends", backends, "--sample", "2", "--json", tmp_path / "all.json")
    checked = json.loads((tmp_path / "all.json").read_text())
    assert checked["engines"]["toy"] == "0.1"
    compared = [comparison for one in checked["instances"] for comparison in one["comparisons"]]
    with_toy = [comparison["within"] for comparison in compared if "toy" in comparison["engines"]]
    assert with_toy == [True] * 2 * len(others)


def test_engine_generates_a_dataset(wmspec: Wmspec, tmp_path: Path) -> None:
    wmspec("generate", FLIGHT, "--backend", "toy", "-o", tmp_path / "out", "--per-task", "2", "--size", "64", "-j", "1")
    assert list((tmp_path / "out").rglob("*.parquet"))


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("run", MEETING), "Toy knows free flight only, and /World/Objects/floor and /World/Objects/far meet at"),
        (("compile", FLIGHT, "-o", "OUT"), "Toy has no form of its own for flight"),
    ],
    ids=["meeting", "native"],
)
def test_missing_capability_is_one_sentence(
    wmspec: Wmspec, tmp_path: Path, arguments: tuple[Any, ...], message: str
) -> None:
    given = [tmp_path if a == "OUT" else a for a in arguments]
    assert message in wmspec(*given, "--backend", "toy", code=2).stderr


def test_the_engines_of_wmspec_stay_the_default(wmspec: Wmspec) -> None:
    installed(ENGINES[0])
    (trace,) = wmspec.json("run", FLIGHT)
    assert trace["engine"] in ENGINES
