"""Shares of a dataset come together to what would have been made at once, and what was made is not made again."""

from __future__ import annotations

import json
import shutil
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import pyarrow.parquet as pq
import pytest

from tests.dataset.made import filling, make, plan
from tests.dataset.test_dataset import contents
from wmspec.compile.design.design import share
from wmspec.core.diagnostics import WmsError
from wmspec.dataset.build.dataset import Dataset
from wmspec.dataset.build.plan import Plan, Task
from wmspec.dataset.build.reuse import PriorInstances

SHARES = 3


def shares(whole: Plan, count: int = SHARES) -> Iterator[Plan]:
    for number in range(1, count + 1):
        tasks = (Task(t.spec, t.indices[share(len(t.indices), number, count)]) for t in whole.tasks)
        yield replace(whole, tasks=tuple(tasks))


@pytest.fixture(scope="module")
def parts(tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    """The folders of the shares of a dataset."""
    folders = [tmp_path_factory.mktemp(f"part-{number}") for number in range(SHARES)]
    for folder, part in zip(folders, shares(plan(count=11)), strict=True):
        make(folder, part)
    return folders


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """That dataset, made at once."""
    folder = tmp_path_factory.mktemp("whole")
    make(folder, plan(count=11))
    return folder


def reuse(folder: Path, made: Plan, folders: list[Path]) -> dict[str, list[int]]:
    """Make a dataset of what is in folders; returns what had to be made, by task."""
    before, new = PriorInstances(folders, made), dict[str, list[int]]()
    with Dataset.open(folder, made) as dataset:
        for shard in dataset.pending():
            rows, rejected = filling(made, replace(shard, indices=before.missing(shard)))
            for outcome in before.outcomes(shard).values():
                rows, rejected = [*rows, *outcome.rows], [*rejected, *outcome.rejected]
            new.setdefault(shard.task.spec.name, []).extend(before.missing(shard))
            dataset.write(shard, rows, rejected)
        dataset.finish()
    return new


def test_shares_come_together_to_the_same_bytes(tmp_path: Path, parts: list[Path], whole: Path) -> None:
    assert reuse(tmp_path / "merged", plan(count=11), parts[::-1]) == {"collide": [], "motion_speed": []}
    assert contents(tmp_path / "merged") == contents(whole)


def test_the_rows_of_the_shares_are_those_of_the_whole(parts: list[Path], whole: Path) -> None:
    for task in ("collide", "motion_speed"):
        expected = pq.read_table(whole / "data" / task).to_pylist()
        rows = [row for part in parts for row in pq.read_table(part / "data" / task).to_pylist()]
        assert len({row["id"] for row in rows}) == len(rows) > 20
        assert rows == expected, "pictures too, byte by byte"


def test_a_dataset_grows(tmp_path: Path) -> None:
    """More of a task than was made before: the first of a sample are those of a smaller sample."""
    make(tmp_path / "small", plan(count=4))
    made, larger = reuse(tmp_path / "larger", plan(count=9), [tmp_path / "small"]), plan(count=9)
    assert made == {t.spec.name: list(t.indices[4:]) for t in larger.tasks}
    make(tmp_path / "whole", larger)
    assert contents(tmp_path / "larger") == contents(tmp_path / "whole")


def test_damaged_or_missing_parts_are_generated_again(tmp_path: Path, parts: list[Path]) -> None:
    part = next(shares(plan(count=11))).tasks[0]
    first = Path(shutil.copytree(parts[0], tmp_path / "first"))
    damaged = first / "data/collide/test-00000-of-00002.parquet"
    damaged.write_bytes(damaged.read_bytes()[:-1])
    (first / "data/collide/test-00001-of-00002.parquet").unlink()
    made = reuse(tmp_path / "merged", plan(count=11), [first, *parts[1:]])
    assert made == {"collide": list(part.indices), "motion_speed": []}


def test_more_shares_than_instances(tmp_path: Path) -> None:
    few = plan(count=2)
    folders = [tmp_path / f"{number}" for number in range(5)]
    for folder, part in zip(folders, shares(few, 5), strict=True):
        make(folder, part)
    assert json.loads((folders[0] / "manifest.json").read_text())["rows"] == 0
    make(tmp_path / "whole", few)
    reuse(tmp_path / "merged", few, folders)
    assert contents(tmp_path / "merged") == contents(tmp_path / "whole")


@pytest.mark.parametrize(
    ("other", "said"),
    [(plan(seed=8), "seed 8 there, 7 now"), (plan(tasks=("collide",)), r"specs \(motion_speed.wms\)")],
)
def test_dataset_of_other_options_is_refused(tmp_path: Path, other: Plan, said: str) -> None:
    make(tmp_path, other)
    with pytest.raises(WmsError, match=f"cannot be reused, .* {said}"):
        PriorInstances([tmp_path], plan())


@pytest.mark.parametrize("text", [None, "", "[]", "{}", '{"tasks": {"collide": 3}}'])
def test_invalid_dataset_is_refused(tmp_path: Path, text: str | None) -> None:
    if text is not None:
        (tmp_path / "plan.json").write_text(text)
    with pytest.raises(WmsError, match="holds no dataset that could be reused"):
        PriorInstances([tmp_path], plan())
