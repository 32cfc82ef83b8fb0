"""A dataset is a function of spec and seed: nothing around the command changes a byte."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import pyarrow.parquet as pq
import pytest

from tests.dataset.made import make, plan
from tests.trust.made import below

SPEC = Path(__file__).parents[1] / "endtoend/specs/speed_tabletop.wms"
#: A clock that jumps back by a day each time it is read, and begins in the future.
BACKWARDS = """
import itertools, time
_days = itertools.count()
time.time = lambda: 4e9 - 86400.0 * next(_days)
time.time_ns = lambda: int(time.time() * 1e9)
"""
PLAIN = {"PYTHONHASHSEED": "0", "LC_ALL": "C", "TZ": "UTC"}
OTHER = {"PYTHONHASHSEED": "4242", "LC_ALL": "tr_TR.UTF-8", "LANGUAGE": "tr", "TZ": "Asia/Kathmandu", "COLUMNS": "31"}


def generated(spec: Path, out: Path, environment: dict[str, str], workers: int, mask: int) -> Path:
    command = [sys.executable, "-m", "wmspec", "generate", spec, "-b", "mujoco", "--per-task", "2", "--size", "48"]
    done = subprocess.run(
        [*map(str, command), "-j", str(workers), "-o", str(out)],
        env={**os.environ, **environment},
        umask=mask,
        capture_output=True,
        text=True,
        check=False,
        timeout=300,
    )
    assert done.returncode == 0, done.stderr
    return out


def contents(folder: Path) -> dict[str, bytes]:
    return {str(path.relative_to(folder)): path.read_bytes() for path in below(folder)}


@pytest.fixture(scope="module")
def plain(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return generated(SPEC, tmp_path_factory.mktemp("plain") / "out", PLAIN, 1, 0o022)


@pytest.mark.slow
@pytest.mark.engine
def test_workers_hash_seed_locale_time_zone_umask_and_a_clock_that_goes_backwards(tmp_path: Path, plain: Path) -> None:
    (tmp_path / "sitecustomize.py").write_text(BACKWARDS)
    path = os.pathsep.join([str(tmp_path), os.environ.get("PYTHONPATH", "")])
    other = generated(SPEC, tmp_path / "out", {**OTHER, "PYTHONPATH": path}, 2, 0o077)
    assert contents(other) == contents(plain)


@pytest.mark.slow
def test_replies_and_a_study_under_a_clock_that_goes_backwards(tmp_path: Path) -> None:
    make(tmp_path / "dataset", plan(count=2), size=24)
    (tmp_path / "sitecustomize.py").write_text(BACKWARDS)
    jumping = os.pathsep.join([str(tmp_path), os.environ.get("PYTHONPATH", "")])
    for name, path in (("plain", os.environ.get("PYTHONPATH", "")), ("jumping", jumping)):
        for command in (
            ["evaluate", tmp_path / "dataset", "-m", "random", "-o", tmp_path / name / "r.parquet"],
            ["study", "make", tmp_path / "dataset", "-o", tmp_path / name / "study", "--per-task", "2"],
        ):
            environment = {**os.environ, "PYTHONPATH": path}
            done = subprocess.run([sys.executable, "-m", "wmspec", *map(str, command)], env=environment, check=False)
            assert done.returncode == 0
    here, there = (
        pq.read_table(tmp_path / name / "r.parquet").drop_columns(["seconds"]) for name in ("plain", "jumping")
    )
    assert here.to_pylist() == there.to_pylist()
    assert contents(tmp_path / "plain/study") == contents(tmp_path / "jumping/study")


def rows(folder: Path) -> list[dict[str, Any]]:
    return [row for path in sorted(folder.rglob("*.parquet")) for row in pq.read_table(path).to_pylist()]


@pytest.mark.slow
@pytest.mark.engine
def test_a_spec_that_is_formatted_otherwise(tmp_path: Path, plain: Path) -> None:
    lines = [f"   {line.strip()}" for line in SPEC.read_text().splitlines()]
    (tmp_path / SPEC.name).write_text("\n".join(lines) + "\n\n")
    other = generated(tmp_path / SPEC.name, tmp_path / "out", PLAIN, 1, 0o022)
    assert json.loads((other / "manifest.json").read_bytes())["tasks"].keys()
    assert rows(other) == rows(plain)
