"""Datasets end to end: the engines agree, and the bytes depend on the options alone."""

import hashlib
import json
import signal
import subprocess
import sys
from pathlib import Path

import pyarrow.parquet as pq

from tests.command import wmspec as command
from tests.endtoend.conftest import OPTIONS
from tests.endtoend.test_commands import SPEED, wmspec
from tests.engines import installed
from wmspec.api import generate
from wmspec.api.generating import DatasetOptions
from wmspec.api.verifying import verify


def digests(folder: Path) -> dict[str, str]:
    files = (p for p in folder.rglob("*") if p.is_file() and p.name != "lock")
    return {str(p.relative_to(folder)): hashlib.sha256(p.read_bytes()).hexdigest() for p in files}


def test_three_engines_agree_or_report_why_not(dataset: Path) -> None:
    manifest = json.loads((dataset / "manifest.json").read_text())
    for task, probed in (("speed_tabletop", 2), ("shove", 4 * 2)):  # four instances of a group, two questions each
        rows = pq.read_table(dataset / f"data/{task}").to_pylist()
        assert rows, "nothing was kept"
        for row in rows:
            assert {a["answer"] for a in row["agreement"]} == {row["answer"]}
            assert {a["engine"] for a in row["agreement"]} == {"mujoco", "pybullet", "sapien"}
        rejected = [r for r in manifest["rejected"]["list"] if r["task"] == task]
        assert len(rows) + len(rejected) == probed, "one row stands for three engines"
        assert {row["renderer"] for row in rows} == {"mujoco"}, "the quickest of them"
        assert all(a["apart"] < 0.1 for row in rows for a in row["agreement"])
        assert all(r["reason"] for r in rejected)


def test_each_engine_has_its_rows_if_rows_are_of_engines(tmp_path: Path) -> None:
    for engine in ("mujoco", "pybullet"):
        installed(engine)
    args = ["generate", SPEED, "-b", "mujoco,pybullet", "--per-task", 3, "--size", 64, "-j", 1]
    command(*args, "--rows", "engines", "-o", "engines", folder=tmp_path)
    generate(SPEED, tmp_path / "questions", per_task=3, size=64, backend="mujoco,pybullet", workers=0)
    engines, questions = (
        pq.read_table(tmp_path / f"{n}/data/speed_tabletop").to_pylist() for n in ("engines", "questions")
    )
    assert {(row["engine"], row["renderer"]) for row in engines} == {("mujoco", "mujoco"), ("pybullet", "pybullet")}
    own = {row["index"]: row for row in engines if row["engine"] == "mujoco"}
    for row in questions:
        assert row == own[row["index"]] | {"id": row["id"]}
    for name in ("engines", "questions"):
        assert verify(tmp_path / name, sample=1, workers=0).verdict == "same"


def test_the_same_bytes_whatever_the_number_of_workers(tmp_path: Path) -> None:
    """Two in the command, none in the dataset that is generated beside it."""
    options: DatasetOptions = {**OPTIONS, "per_task": 4}
    generate(SPEED, tmp_path / "alone", workers=0, **options)
    args = ["generate", SPEED, "-o", "two", "-b", OPTIONS["backend"], "--seed", OPTIONS["seed"]]
    args += ["--per-task", 4, "--size", OPTIONS["size"]]
    wmspec(*args, "-j", 2, folder=tmp_path)
    assert digests(tmp_path / "two") == digests(tmp_path / "alone")
    command(*args, folder=tmp_path)
    assert digests(tmp_path / "two") == digests(tmp_path / "alone"), "asking again changes nothing"


CROWDED = """
task crowded : custom {
  use tabletop
  factor   tone in [red, blue] about color
  nuisance gap  in 0 cm .. 90 cm by 90 cm
  design groups of 6 { cross: tone }
  objects dots[3] { shape: sphere  size: 12 cm  color: tone  on: table  scatter: (40 cm, 40 cm)  gap: gap }
  observe front at [0 s]
  question "Which colour do the balls have?" {
    options [red, blue]
    answer  tone
  }
}
"""


def test_the_same_bytes_wherever_the_spec_lies_also_of_what_is_rejected(tmp_path: Path) -> None:
    installed("mujoco")
    folders = tmp_path / "here", tmp_path / "far away"
    for folder in folders:
        folder.mkdir()
        (folder / "crowded.wms").write_text(CROWDED)
        args = ["generate", folder / "crowded.wms", "-b", "mujoco", "--size", 64, "-j", 1]
        command(*args, "-o", folder / "made", folder=tmp_path)
    here, there = (folder / "made" for folder in folders)
    rejected = json.loads((here / "manifest.json").read_text())["rejected"]["list"]
    assert {r["reason"] for r in rejected} == {"invalid"}
    assert all(r["detail"].startswith("crowded.wms:7:") for r in rejected)
    assert digests(here) == digests(there)
    assert verify(there, workers=0).verdict == "same"


KILLED = """
import os, signal
from wmspec.cli import main
from wmspec.dataset.build import checkpoint

save, saved = checkpoint.save, []

def save_three(*instance):
    save(*instance)
    saved.append(instance)
    if len(saved) == 3:
        os.killpg(0, signal.SIGKILL)

checkpoint.save = save_three
main()
"""


def test_a_killed_run_goes_on_with_the_next_instance(tmp_path: Path) -> None:
    installed("mujoco")
    args = ["generate", SPEED, "-b", "mujoco", "--per-task", 8, "--size", 64, "-j", 1]
    killed = [sys.executable, "-c", KILLED, *map(str, args), "-o", "killed"]
    done = subprocess.run(killed, cwd=tmp_path, stderr=subprocess.DEVNULL, start_new_session=True, check=False)
    assert done.returncode == -signal.SIGKILL
    assert len(list((tmp_path / "killed/.progress").rglob("*.instance"))) == 3
    assert not (tmp_path / "killed/data").exists()
    reported = command(*args, "-o", "killed", folder=tmp_path).stderr
    assert reported.startswith("3 of 8 instances"), "the first reported"
    generate(SPEED, tmp_path / "whole", per_task=8, size=64, backend="mujoco", workers=0)
    assert digests(tmp_path / "killed") == digests(tmp_path / "whole")


def test_shares_of_two_machines_come_together(tmp_path: Path) -> None:
    installed("mujoco")
    generate(SPEED, tmp_path / "whole", per_task=5, size=64, backend="mujoco", workers=0)
    args = ["generate", SPEED, "-b", "mujoco", "--per-task", 5, "--size", 64, "-j", 1]
    for number in (1, 2):
        command(*args, "-o", f"part-{number}", "--shard", f"{number}/2", folder=tmp_path)
        command("view", f"part-{number}", folder=tmp_path)
    command(*args, "-o", "merged", "--reuse", "part-1", "--reuse", "part-2", folder=tmp_path)
    assert digests(tmp_path / "merged") == digests(tmp_path / "whole")


def test_one_engine_may_draw_what_another_executes(tmp_path: Path) -> None:
    for engine in ("mujoco", "pybullet"):
        installed(engine)
    args = ["generate", SPEED, "-b", "mujoco", "-r", "pybullet", "--per-task", 1, "--size", 64, "-j", 1]
    command(*args, "-o", "out", folder=tmp_path)
    rows = pq.read_table(tmp_path / "out/data/speed_tabletop").to_pylist()
    assert [(row["engine"], row["renderer"]) for row in rows] == [("mujoco", "pybullet")]
