"""A stopped run loses no finished instance, and the resumed result has the same bytes."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from tests.dataset.made import filling, make, plan
from tests.dataset.test_dataset import contents, largest_file
from tests.examples import slow_except
from wmspec.core.diagnostics import WmsError
from wmspec.dataset.build.dataset import Dataset
from wmspec.dataset.build.generate import generate
from wmspec.dataset.build.plan import Shard
from wmspec.dataset.build.reuse import PriorInstances
from wmspec.dataset.build.worker import BatchResult, Job, Outcome
from wmspec.runtime.questions.model import Rejected
from wmspec.runtime.workers.pool import PoolConfig

Listed = list[tuple[str, int]]
Run = Callable[..., Listed]

PLAN = plan(count=11, shard=4)
ALL = [(shard.task.spec.name, index) for shard in PLAN.shards() for index in shard.indices]


class Stopped(Exception):
    """The run is over before its work is done."""


def outcome(shard: Shard, index: int) -> Outcome:
    rows, rejected = filling(PLAN, replace(shard, indices=(index,)))
    return Outcome(tuple(rows), tuple(rejected))


@pytest.fixture
def run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Run:
    """Make a dataset with drawn pictures, `most` instances of it, and say which."""

    def made_by(most: int = len(ALL), before: Iterable[Path] = ()) -> Listed:
        made: Listed = []

        def map_batches(
            work: Any, units: Iterable[list[tuple[Any, str, tuple[int]]]], effort: PoolConfig, weight: Any
        ) -> Iterator[tuple[tuple[Any, str, tuple[int]], BatchResult]]:
            for _, task, (index,) in sorted(
                (piece for unit in units for piece in unit), key=lambda p: ALL.index((p[1], p[2][0]))
            ):
                if len(made) == most:
                    raise Stopped
                made.append((task, index))
                yield (
                    (None, task, (index,)),
                    BatchResult((outcome(next(s for s in PLAN.shards() if s.task.spec.name == task), index),)),
                )

        monkeypatch.setattr("wmspec.dataset.build.generate.map_batches", map_batches)
        with Dataset.open(tmp_path / "out", PLAN) as dataset:
            generate(dataset, PoolConfig(1, 1), lambda task, count: None, PriorInstances(before, PLAN))
            dataset.finish()
        return made

    return made_by


def left(folder: Path) -> list[Path]:
    return sorted((folder / ".progress").rglob("*.instance"))


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> dict[str, bytes]:
    folder = tmp_path_factory.mktemp("whole")
    make(folder, PLAN)
    return contents(folder)


@pytest.mark.parametrize("most", slow_except([3, 4], [1, 3, 4, 7]))
def test_no_instance_is_generated_twice_despite_interruptions(
    tmp_path: Path, whole: dict[str, bytes], run: Run, most: int
) -> None:
    for done in range(most, len(ALL), most):
        with pytest.raises(Stopped):
            run(most)
        assert len(left(tmp_path / "out")) == (done % 11) % 4, "of the shard that is not whole, and no other"
    assert run() == ALL[len(ALL) - 1 - (len(ALL) - 1) % most :]
    assert contents(tmp_path / "out") == whole
    assert not [p for p in (tmp_path / "out").rglob("*") if p.is_dir() and not any(p.iterdir())]


def test_checkpoints_and_reused_instances_combine(tmp_path: Path, whole: dict[str, bytes], run: Run) -> None:
    with pytest.raises(Stopped):
        run(2)
    few = replace(PLAN, tasks=tuple(replace(t, indices=t.indices[:3]) for t in PLAN.tasks))
    make(tmp_path / "few", few)
    reused = [(t.spec.name, i) for t in few.tasks for i in t.indices]
    assert run(before=[tmp_path / "few"]) == [piece for piece in ALL if piece not in reused]
    assert contents(tmp_path / "out") == whole


@pytest.mark.parametrize("damage", [lambda b: b[:-1], lambda b: b[:-50] + bytes([b[-50] ^ 1]) + b[-49:], lambda b: b""])
def test_damaged_checkpoint_is_generated_again(
    tmp_path: Path, whole: dict[str, bytes], run: Run, damage: Callable[[bytes], bytes]
) -> None:
    with pytest.raises(Stopped):
        run(3)
    damaged = next(p for p in left(tmp_path / "out") if p.name.startswith(f"{ALL[1][1]}-"))
    damaged.write_bytes(damage(damaged.read_bytes()))
    assert run() == [ALL[1], *ALL[3:]]
    assert contents(tmp_path / "out") == whole


def test_checkpoint_of_a_complete_shard_is_removed(tmp_path: Path, whole: dict[str, bytes]) -> None:
    make(tmp_path, PLAN)
    with Dataset.open(tmp_path, PLAN) as dataset:
        shard = next(PLAN.shards())
        dataset.keep(shard, shard.indices[0], outcome(shard, shard.indices[0]))
    assert left(tmp_path)
    make(tmp_path, PLAN)
    assert contents(tmp_path) == whole


def test_checkpoint_of_another_plan_is_not_used(tmp_path: Path, run: Run) -> None:
    with pytest.raises(Stopped):
        run(3)
    other = replace(PLAN, seed=8, tasks=PLAN.tasks[1:])
    with Dataset.open(tmp_path / "out", other, force=True) as dataset:
        assert not left(tmp_path / "out")
        shard = dataset.pending()[0]
        dataset.keep(shard, shard.indices[0], outcome(shard, shard.indices[0]))
        assert list(dataset.kept(shard)) == [shard.indices[0]]
        dataset.plan = PLAN
        assert not dataset.kept(shard)


def test_instance_file_appears_when_complete(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A run that is killed at any moment, here before the file gets its name, leaves nothing that counts."""
    shard = next(PLAN.shards())

    def killed(*paths: Path) -> None:
        raise KeyboardInterrupt

    with Dataset.open(tmp_path, PLAN) as dataset:
        with monkeypatch.context() as patched:
            patched.setattr(Path, "replace", killed)
            with pytest.raises(KeyboardInterrupt):
                dataset.keep(shard, shard.indices[0], outcome(shard, shard.indices[0]))
        assert not left(tmp_path)
        assert not dataset.kept(shard)
        dataset.keep(shard, shard.indices[0], outcome(shard, shard.indices[0]))
        assert list(dataset.kept(shard)) == [shard.indices[0]]


def test_full_disk_is_an_error_when_an_instance_is_saved(tmp_path: Path, whole: dict[str, bytes], run: Run) -> None:
    with pytest.raises(Stopped):
        run(2)
    with largest_file(3000), pytest.raises(WmsError, match=r"\.instance cannot be written.*free some space.*again"):
        run()
    assert len(left(tmp_path / "out")) == 2
    assert run() == ALL[2:]
    assert contents(tmp_path / "out") == whole


# ---------------------------------------------------------------- what failed


def fails(job: Job, task: str, indices: tuple[int]) -> BatchResult:
    """An instance in which something unforeseen happens, as the third of each task does."""
    (index,) = indices
    if (task, index) in (ALL[2], ALL[13]):
        raise ZeroDivisionError("division by zero")
    return BatchResult((outcome(next(s for s in PLAN.shards() if s.task.spec.name == task), index),))


def test_failed_instance_costs_no_other_and_has_a_reason(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("wmspec.dataset.build.generate.make_instances", fails)
    with Dataset.open(tmp_path, PLAN) as dataset:
        generate(dataset, PoolConfig(0, 1), lambda task, count: None, PriorInstances((), PLAN))
        summary = dataset.finish()
    assert summary.rejected["error"] == 2 * len(PLAN.engines)
    listed = json.loads((tmp_path / "manifest.json").read_bytes())["rejected"]["list"]
    wrong = [r for r in listed if r["reason"] == "error"]
    assert {(r["task"], r["index"]) for r in wrong} == {ALL[2], ALL[13]}
    assert {r["detail"] for r in wrong} == {"ZeroDivisionError: division by zero"}
    assert "| something went wrong" in (tmp_path / "README.md").read_text()


def with_lost(folder: Path, *pieces: tuple[str, int]) -> None:
    """A finished dataset of which these instances took too long."""
    with Dataset.open(folder, PLAN) as dataset:
        for shard in dataset.pending():
            name = shard.task.spec.name
            rows, rejected = filling(PLAN, shard)
            late = {i for task, i in pieces if task == name and i in shard.indices}
            rows = [r for r in rows if r["index"] not in late]
            rejected = [r for r in rejected if r.index not in late]
            rejected += [Rejected(name, i, 0, e, "timeout", "too long") for e in PLAN.engines for i in sorted(late)]
            dataset.write(shard, rows, rejected)
        dataset.finish()


def test_only_timed_out_instances_are_retried(tmp_path: Path, whole: dict[str, bytes], run: Run) -> None:
    with_lost(tmp_path / "out", ALL[1], ALL[13])
    assert run() == [ALL[1], ALL[13]]
    assert contents(tmp_path / "out") == whole
    assert run() == []


def test_timed_out_instances_are_not_reused(tmp_path: Path, whole: dict[str, bytes], run: Run) -> None:
    with_lost(tmp_path / "late", ALL[0], ALL[5])
    assert run(before=[tmp_path / "late"]) == [ALL[0], ALL[5]]
    assert contents(tmp_path / "out") == whole


def test_a_failure_that_was_kept_is_tried_again(tmp_path: Path, whole: dict[str, bytes], run: Run) -> None:
    with pytest.raises(Stopped):
        run(2)
    with Dataset.open(tmp_path / "out", PLAN) as dataset:
        shard = next(PLAN.shards())
        lost = tuple(Rejected(ALL[2][0], ALL[2][1], 0, e, "crashed", "twice") for e in PLAN.engines)
        dataset.keep(shard, ALL[2][1], Outcome((), lost))
    assert run() == ALL[2:]
    assert contents(tmp_path / "out") == whole


@pytest.mark.parametrize("moment", slow_except([0, 2, 5, 7], range(8)))
def test_trying_again_can_be_killed_at_any_moment(
    tmp_path: Path, whole: dict[str, bytes], run: Run, monkeypatch: pytest.MonkeyPatch, moment: int
) -> None:
    with_lost(tmp_path / "out", ALL[1])
    real, left_over = Path.replace, [moment]

    def killed(path: Path, target: Path) -> Path:
        if not left_over[0]:
            raise KeyboardInterrupt
        left_over[0] -= 1
        return real(path, target)

    with monkeypatch.context() as patched:
        patched.setattr(Path, "replace", killed)
        with pytest.raises(KeyboardInterrupt):
            run()
    assert set(run()) <= {ALL[1]}, "nothing else was lost"
    assert contents(tmp_path / "out") == whole
