"""The built wheel works in an environment that has only numpy and usd-core."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import venv
from importlib.metadata import distribution
from pathlib import Path

import numpy as np
import pytest

pytestmark = pytest.mark.build
PROJECT = Path(__file__).parents[1]
DATA = PROJECT / "tests/data"


def run(*command: str | Path, cwd: Path) -> subprocess.CompletedProcess[str]:
    """A command without Python's settings of these tests."""
    clean = {name: value for name, value in os.environ.items() if not name.startswith("PYTHON")}
    return subprocess.run([*map(str, command)], cwd=cwd, env=clean, capture_output=True, text=True, check=False)


def link(name: str, site: Path) -> None:
    """Links the files of an installed distribution into another site-packages, so that no network is needed."""
    files = distribution(name).files
    assert files, name
    for top in {file.parts[0] for file in files} - {"..", "__pycache__"}:
        (site / top).symlink_to(Path(str(distribution(name).locate_file(top))).resolve())


@pytest.fixture(scope="module")
def programs(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The programs of the environment."""
    folder = tmp_path_factory.mktemp("alone")
    built = run(sys.executable, "-m", "hatchling", "build", "-t", "wheel", "-d", folder, cwd=PROJECT)
    assert built.returncode == 0, built.stderr
    (wheel,) = folder.glob("usdphysics_conformance-*.whl")
    venv.create(folder / "venv", symlinks=True)
    pip = [sys.executable, "-m", "pip", "--python", folder / "venv/bin/python"]
    installed = run(*pip, "install", "--quiet", "--no-deps", "--no-index", wheel, cwd=folder)
    assert installed.returncode == 0, installed.stderr
    (site,) = folder.glob("venv/lib/python*/site-packages")
    for name in ("numpy", "usd-core"):
        link(name, site)
    return folder / "venv/bin"


def test_the_environment_has_nothing_else(programs: Path, tmp_path: Path) -> None:
    code = "import importlib.metadata as m; print(*sorted(d.name for d in m.distributions()))"
    assert run(programs / "python", "-c", code, cwd=tmp_path).stdout.split() == [
        "numpy",
        "usd-core",
        "usdphysics-conformance",
    ]
    assert "No module named 'wmspec'" in run(programs / "python", "-c", "import wmspec", cwd=tmp_path).stderr


def test_it_writes_stages_and_scores_traces(programs: Path, tmp_path: Path) -> None:
    program = programs / "usdphysics-conformance"
    written = run(program, "write", "stages", cwd=tmp_path)
    assert written.returncode == 0, written.stderr
    assert len(list((tmp_path / "stages").glob("*.usda"))) == 74
    cases = [option for name in ("free_fall", "collide_equal", "filtered_pair") for option in ("--case", name)]
    good = run(program, "score", f"mujoco={DATA / 'mujoco'}", *cases, "--json", cwd=tmp_path)
    assert good.returncode == 0, good.stderr
    assert all(record["passed"] for record in json.loads(good.stdout))


def test_wrong_trace_fails(programs: Path, tmp_path: Path) -> None:
    with np.load(DATA / "mujoco/free_fall.npz") as file:
        wrong = dict(file)
    wrong["position"] = 10 + 1.02 * (wrong["position"] - 10)  # 2 % too much gravity
    np.savez(tmp_path / "free_fall.npz", **wrong)
    done = run(programs / "usdphysics-conformance", "score", "wrong=.", "--case", "free_fall", cwd=tmp_path)
    assert done.returncode == 1, done.stderr
    assert done.stdout.splitlines()[-1] == "wrong: 0 of 1"
