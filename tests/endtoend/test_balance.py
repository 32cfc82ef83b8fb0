"""Balanced answers: equal counts, the same bytes for any division of the work, and the cost is printed."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import pyarrow.parquet as pq
import pytest
from click.testing import CliRunner

import wmspec
from tests.engines import installed
from wmspec.cli import main

SPEC = """
use tabletop

task reach : prediction.mechanistic.friction {
  factor   tone in [red, blue]
  nuisance pace in 0.3 m/s .. 0.9 m/s
  design groups of 5 { cross: tone  balance: far }

  object block { shape: cube  size: 6 cm  color: tone  friction: 0.4  on: table at (-25 cm, 0) }

  action push = launch(block, direction: right, speed: pace) at 0.1 s
  horizon 0.5 s

  observe front at [0 s]

  question far "Does the {tone} cube slide further than 7 cm?" {
    answer displacement(block) > 7 cm
  }
  question near "Does it slide at all?" {
    answer displacement(block) > 0.5 cm
  }
}
"""
pytestmark = pytest.mark.engine


@pytest.fixture(scope="module")
def spec(tmp_path_factory: pytest.TempPathFactory) -> Path:
    installed("mujoco")
    path = tmp_path_factory.mktemp("spec") / "reach.wms"
    path.write_text(SPEC)
    return path


@pytest.fixture(scope="module")
def whole(spec: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    return made(spec, tmp_path_factory.mktemp("whole") / "out")


def made(spec: Path, folder: Path, **more: object) -> Path:
    wmspec.generate(spec, folder, **({"backend": "mujoco", "size": 32, "workers": 0} | more))
    return folder


def table(folder: Path) -> bytes:
    (file,) = (folder / "data/reach").iterdir()
    return file.read_bytes()


def test_every_answer_comes_equally_often_in_whole_groups(spec: Path, whole: Path) -> None:
    rows = [r for r in pq.read_table(whole / "data/reach").to_pylist() if r["question_name"] == "far"]
    assert Counter(row["answer_value"] for row in rows if row["block"] < 4) == {"yes": 4, "no": 4}
    by_block: dict[int, list[dict[str, object]]] = {}
    for row in rows:
        by_block.setdefault(row["block"], []).append(row)
    assert len(by_block) == 5
    assert all(len({(row["redrawn"], row["nuisance.pace"]) for row in members}) == 1 for members in by_block.values())
    assert {row["redrawn"] for row in rows} > {0}
    task = wmspec.load(spec)
    for row in rows:  # and any of them can be had again
        again = task[row["index"]].redrawn(row["redrawn"])
        assert again.nuisances["pace"] == row["nuisance.pace"]
    far = next(row for row in rows if row["redrawn"])
    assert task[far["index"]].redrawn(far["redrawn"]).ask("mujoco", size=32)[0].value == far["answer_value"]


def test_shares_make_up_the_whole_to_the_byte(spec: Path, whole: Path, tmp_path: Path) -> None:
    parts = [made(spec, tmp_path / str(n), part=(n, 3)) for n in (1, 2, 3)]  # which cut groups and laps in two
    assert table(made(spec, tmp_path / "again", reuse=parts)) == table(whole)


def test_workers_leave_no_trace(spec: Path, whole: Path, tmp_path: Path) -> None:
    assert table(made(spec, tmp_path / "out", workers=2)) == table(whole)


@pytest.mark.parametrize("after", [1, 5])
def test_an_interruption_leaves_no_trace(spec: Path, whole: Path, tmp_path: Path, after: int) -> None:
    @contextmanager
    def stopping(total: int, what: str, unit: str = "") -> Iterator[Callable[[str, int], None]]:
        count = 0

        def advance(task: str, by: int) -> None:
            nonlocal count
            count += by
            if count == after:
                raise KeyboardInterrupt

        yield advance

    with pytest.raises(KeyboardInterrupt):
        made(spec, tmp_path / "out", progress=stopping)
    assert table(made(spec, tmp_path / "out")) == table(whole)


def test_cost_is_printed(spec: Path, tmp_path: Path) -> None:
    args = ["-b", "mujoco", "--size", "32", "--per-task", "4", "-j", "1"]
    output = CliRunner().invoke(main, ["generate", str(spec), "-o", str(tmp_path / "out"), *args]).output
    assert "reach: answers are balanced, for which " in output
    assert " groups were executed and 2 kept (" in output
    tried = CliRunner().invoke(main, ["generate", str(spec), "--dry-run", *args]).output
    assert "reach: answers are balanced, for which " in tried
    checked = CliRunner().invoke(main, ["check", str(spec)]).output
    assert "balanced answers of `far`: each group is drawn up to 32 times" in checked
    assert "5 independent groups: the sample size of tone, pace" in checked
    verified = CliRunner().invoke(main, ["verify", str(tmp_path / "out"), "--all", "-j", "1"])
    assert verified.exit_code == 0, verified.output
