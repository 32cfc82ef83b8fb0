"""The dataset folder: the same bytes in any order of work, nothing half-written, mistakes reported with a remedy."""

from __future__ import annotations

import json
import os
import resource
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

import datasets
import pytest
import yaml
from PIL import Image

from tests.dataset.made import filling, make, plan
from tests.examples import slow_except
from wmspec.core.diagnostics import WmsError
from wmspec.dataset.build.card import card
from wmspec.dataset.build.dataset import Dataset
from wmspec.dataset.build.manifest import Summary
from wmspec.dataset.build.plan import Plan
from wmspec.runtime.questions.model import Rejected

ROOT = Path(__file__).parents[2]


def contents(folder: Path) -> dict[str, bytes]:
    return {str(p.relative_to(folder)): p.read_bytes() for p in sorted(folder.rglob("*")) if p.is_file()}


@pytest.fixture(scope="module")
def original(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A dataset that was made in one go."""
    folder = tmp_path_factory.mktemp("whole")
    make(folder, plan())
    return folder


@pytest.fixture(scope="module")
def whole(original: Path) -> dict[str, bytes]:
    """Its bytes."""
    return contents(original)


@pytest.fixture
def made(original: Path, tmp_path: Path) -> Path:
    """A copy of it, to change."""
    return Path(shutil.copytree(original, tmp_path, dirs_exist_ok=True))


# ---------------------------------------------------------------- the same bytes


def test_the_order_of_the_work_leaves_no_trace(tmp_path: Path, whole: dict[str, bytes]) -> None:
    with Dataset.open(tmp_path, plan()) as dataset:
        for shard in reversed(dataset.pending()):
            rows, rejected = filling(plan(), shard)
            dataset.write(shard, rows[::-1], rejected[::-1])
        dataset.finish()
    assert contents(tmp_path) == whole


def test_another_seed_makes_another_dataset(tmp_path: Path, whole: dict[str, bytes]) -> None:
    make(tmp_path, plan(seed=8))
    assert contents(tmp_path).keys() == whole.keys()
    assert contents(tmp_path) != whole


def test_opening_a_finished_dataset_changes_nothing(tmp_path: Path, whole: dict[str, bytes]) -> None:
    for _ in range(2):
        with Dataset.open(tmp_path, plan()) as dataset:
            for shard in dataset.pending():
                dataset.write(shard, *filling(plan(), shard))
            dataset.finish()
    assert dataset.notices == []
    assert contents(tmp_path) == whole


# ---------------------------------------------------------------- going on


def test_only_a_lost_shard_is_generated_again(made: Path, whole: dict[str, bytes]) -> None:
    lost = "data/collide/test-00001-of-00003.parquet"
    (made / lost).unlink()
    with Dataset.open(made, plan()) as dataset:
        assert [s.path for s in dataset.pending()] == [lost]
        assert dataset.notices == [f"{lost} is missing; it will be made again"]
        assert not (made / "manifest.json").exists()
    make(made, plan())
    assert contents(made) == whole


@pytest.mark.parametrize("damage", [lambda b: b[:-1], lambda b: b[:50] + bytes([b[50] ^ 1]) + b[51:], lambda b: b""])
def test_tampered_shard_is_named_and_generated_again(
    made: Path, whole: dict[str, bytes], damage: Callable[[bytes], bytes]
) -> None:
    shard = made / "data/motion_speed/test-00000-of-00003.parquet"
    shard.write_bytes(damage(shard.read_bytes()))
    with Dataset.open(made, plan()) as dataset:
        assert len(dataset.pending()) == 1
        assert "motion_speed/test-00000" in dataset.notices[0]
    make(made, plan())
    assert contents(made) == whole


@pytest.mark.parametrize("damage", [b"", b"{", b"[]", b'{"rows": 1}', b"\xff"])
def test_a_damaged_record_costs_its_shard(tmp_path: Path, whole: dict[str, bytes], damage: bytes) -> None:
    with Dataset.open(tmp_path, plan()) as dataset:
        for shard in dataset.pending():
            dataset.write(shard, *filling(plan(), shard))
    (tmp_path / ".progress/collide/00000.json").write_bytes(damage)
    with Dataset.open(tmp_path, plan()) as dataset:
        assert [s.path for s in dataset.pending()] == ["data/collide/test-00000-of-00003.parquet"]
    make(tmp_path, plan())
    assert contents(tmp_path) == whole


WRITER = """
import time, sys
from pathlib import Path
from tests.dataset.made import filling, plan
from wmspec.dataset.build.dataset import Dataset
with Dataset.open(Path(sys.argv[1]), plan()) as dataset:
    for shard in dataset.pending():
        dataset.write(shard, *filling(plan(), shard))
        print(shard.path, flush=True)
    dataset.finish()
"""


@pytest.mark.parametrize("delay", slow_except([0.01], [0.0, 0.01, 0.03]))
def test_a_killed_writer_loses_at_most_one_shard(tmp_path: Path, whole: dict[str, bytes], delay: float) -> None:
    writer = subprocess.Popen(
        [sys.executable, "-c", WRITER, str(tmp_path)], cwd=ROOT, stdout=subprocess.PIPE, text=True
    )
    assert writer.stdout is not None
    first = writer.stdout.readline().strip()
    time.sleep(delay)
    writer.send_signal(signal.SIGKILL)
    writer.wait()
    with Dataset.open(tmp_path, plan()) as dataset:
        assert dataset.notices == []
        assert first not in {s.path for s in dataset.pending()}
        for shard in dataset.pending():
            dataset.write(shard, *filling(plan(), shard))
        dataset.finish()
    assert contents(tmp_path) == whole


def test_leftovers_of_a_killed_writer_are_removed(tmp_path: Path, whole: dict[str, bytes]) -> None:
    Dataset.open(tmp_path, plan()).close()
    (tmp_path / ".progress").mkdir()
    (tmp_path / ".progress/0123456789abcdef.part").write_bytes(b"half")
    make(tmp_path, plan())
    assert contents(tmp_path) == whole


def test_two_processes_do_not_write_to_one_folder(tmp_path: Path) -> None:
    with Dataset.open(tmp_path, plan()), pytest.raises(WmsError, match="another process is writing"):
        Dataset.open(tmp_path, plan())
    Dataset.open(tmp_path, plan()).close()


# ---------------------------------------------------------------- another plan


@pytest.mark.parametrize(
    ("other", "said"),
    [
        (lambda p: replace(p, seed=9), "seed 7 there, 9 now"),
        (lambda p: replace(p, size=(32, 32)), "size 64 64 there, 32 32 now"),
        (lambda p: replace(p, consensus="none"), "consensus all there, none now"),
        (lambda p: replace(p, engines=p.engines[:1]), "engines mujoco pybullet sapien there, mujoco now"),
        (lambda p: replace(p, versions=p.versions | {"mujoco": "4.1"}), "versions (mujoco 4.0 there, 4.1 now)"),
        (lambda p: replace(p, texts=p.texts | {"collide.wms": "changed"}), "specs (collide.wms)"),
        (lambda p: replace(p, tasks=p.tasks[:1]), "tasks (motion_speed)"),
    ],
)
def test_other_plan_is_recognized_and_needs_force(made: Path, other: Callable[[Plan], Plan], said: str) -> None:
    before = contents(made)
    with pytest.raises(WmsError) as error:
        Dataset.open(made, other(plan()))
    assert said in str(error.value)
    assert "--force" in str(error.value)
    assert contents(made) == before
    with Dataset.open(made, other(plan()), force=True) as dataset:
        assert dataset.pending() == tuple(other(plan()).shards())


def test_force_removes_only_own_output(tmp_path: Path, whole: dict[str, bytes]) -> None:
    make(tmp_path, plan(seed=8, tasks=("collide",)))
    mine = [tmp_path / "notes.txt", tmp_path / "data/collide/mine.txt", tmp_path / "data/mine.parquet"]
    for note in mine:
        note.write_text("mine")
    with Dataset.open(tmp_path, plan(), force=True) as dataset:
        for shard in dataset.pending():
            dataset.write(shard, *filling(plan(), shard))
        dataset.finish()
    for note in mine:
        assert note.read_text() == "mine"
        note.unlink()
    assert contents(tmp_path) == whole


@pytest.mark.parametrize("damage", [b"", b"{", b"[]", b"{}"])
def test_a_damaged_plan_needs_force(made: Path, whole: dict[str, bytes], damage: bytes) -> None:
    (made / "plan.json").write_bytes(damage)
    with pytest.raises(WmsError, match="--force"):
        Dataset.open(made, plan())
    Dataset.open(made, plan(), force=True).close()
    make(made, plan())
    assert contents(made) == whole


@pytest.mark.parametrize("force", [False, True])
def test_foreign_folder_is_not_overwritten(tmp_path: Path, force: bool) -> None:
    (tmp_path / "README.md").write_text("my project")
    with pytest.raises(WmsError, match="not a dataset"):
        Dataset.open(tmp_path, plan(), force=force)
    assert (tmp_path / "README.md").read_text() == "my project"


def test_two_tasks_of_one_name_are_refused() -> None:
    with pytest.raises(WmsError, match="two of the specs define a task `collide`"):
        replace(plan(), tasks=plan().tasks[:1] * 2)


# ---------------------------------------------------------------- the disk


@contextmanager
def largest_file(size: int) -> Iterator[None]:
    """No file may be larger (bytes)."""
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)


def test_a_disk_that_is_full_leaves_nothing_half_written(tmp_path: Path, whole: dict[str, bytes]) -> None:
    with Dataset.open(tmp_path, plan()) as dataset:
        shards = dataset.pending()
        dataset.write(shards[0], *filling(plan(), shards[0]))
        before = contents(tmp_path)
        content = filling(plan(), shards[1])
        with largest_file(2000), pytest.raises(WmsError, match=r"test-00001-of-00003\.parquet.*free some space"):
            dataset.write(shards[1], *content)
        assert contents(tmp_path) == before
    make(tmp_path, plan())
    assert contents(tmp_path) == whole


@pytest.fixture
def small_disk(tmp_path: Path) -> Iterator[Path]:
    """A disk of 128 KiB, if this user may mount one."""
    disk = tmp_path / "disk"
    disk.mkdir()
    mounted = shutil.which("mount") and subprocess.run(
        ["mount", "-t", "tmpfs", "-o", "size=128k", "tmpfs", str(disk)], check=False, capture_output=True
    )
    if not mounted or mounted.returncode:
        pytest.skip("mounting needs root")
    yield disk
    subprocess.run(["umount", "-l", str(disk)], check=True)


def test_full_disk_is_an_error_and_the_run_resumes_with_space(small_disk: Path, whole: dict[str, bytes]) -> None:
    with pytest.raises(WmsError, match=r"no space left.*free some space"):
        make(small_disk, plan())
    assert not list(small_disk.rglob("*.part"))
    subprocess.run(["mount", "-o", "remount,size=8m", str(small_disk)], check=True)
    with Dataset.open(small_disk, plan()) as dataset:
        assert len(dataset.pending()) < len(list(plan().shards()))
    make(small_disk, plan())
    assert contents(small_disk) == whole


def test_a_file_where_the_folder_should_be(tmp_path: Path) -> None:
    (tmp_path / "out").write_text("a file")
    for place in (tmp_path / "out", tmp_path / "out" / "deeper"):
        with pytest.raises(WmsError, match="in the way"):
            Dataset.open(place, plan())
    assert (tmp_path / "out").read_text() == "a file"


def test_a_file_where_a_task_should_be(tmp_path: Path) -> None:
    with Dataset.open(tmp_path, plan()) as dataset:
        (tmp_path / "data").mkdir()
        (tmp_path / "data/collide").write_text("a file")
        shard = dataset.pending()[0]
        with pytest.raises(WmsError, match="in the way"):
            dataset.write(shard, *filling(plan(), shard))


def test_a_folder_that_may_not_be_written(tmp_path: Path) -> None:
    tmp_path.chmod(0o500)
    place = tmp_path / "out" if os.geteuid() else Path("/proc/out")  # root may write everywhere but there
    try:
        with pytest.raises(WmsError, match="choose another folder with -o"):
            Dataset.open(place, plan())
    finally:
        tmp_path.chmod(0o700)


@pytest.mark.parametrize("name", ["-o/ünïcødé 数据/🎲 a'b\"c/[x]*?%41", "x" * 240])
def test_strange_paths(tmp_path: Path, whole: dict[str, bytes], name: str) -> None:
    folder = tmp_path / name
    make(folder, plan())
    assert contents(folder) == whole


def test_a_name_that_is_too_long(tmp_path: Path) -> None:
    with pytest.raises(WmsError, match="longer than the file system allows"):
        Dataset.open(tmp_path / ("x" * 300), plan())


# ---------------------------------------------------------------- nothing vanishes


def test_every_instance_is_accounted_for(tmp_path: Path) -> None:
    with Dataset.open(tmp_path, plan()) as dataset:
        shard = dataset.pending()[0]
        rows, rejected = filling(plan(), shard)
        foreign = Rejected("collide", 10**6, 0, "mujoco", "ensure", "")
        for wrong in ((rows[1:], rejected), (rows + rows[:1], rejected), (rows, [*rejected, foreign])):
            with pytest.raises(ValueError, match="missing, foreign or given twice"):
                dataset.write(shard, *wrong)
        assert not (tmp_path / "data").exists()


def test_an_unfinished_dataset_cannot_be_finished(tmp_path: Path) -> None:
    with Dataset.open(tmp_path, plan()) as dataset, pytest.raises(WmsError, match=r"6 shards .* still to be made"):
        dataset.finish()


def test_manifest_counts_are_true(tmp_path: Path) -> None:
    made = plan(count=12, shard=5)
    with Dataset.open(tmp_path, made) as dataset:
        for shard in dataset.pending():
            dataset.write(shard, *filling(made, shard))
        total = dataset.finish()
    said = json.loads((tmp_path / "manifest.json").read_text())
    lost = sum(i % 5 == 0 for t in made.tasks for i in t.indices) * 3
    assert lost > 0
    assert said["rejected"]["count"] == total.rejected == {"alike": lost}
    assert len(said["rejected"]["list"]) == lost
    assert said["rows"] == total.rows == 2 * 12 * 3 - lost
    assert sum(s["rows"] for s in said["shards"].values()) == total.rows
    assert said["specs"]["collide.wms"]["text"] == made.texts["collide.wms"]
    assert said["fingerprint"] == made.fingerprint
    assert str(total).splitlines()[-1] == f"{total.rows} questions, {lost} rejected ({lost} alike)"


def empty(folder: Path, made: Plan, without: str) -> None:
    """A dataset in which every question of the task `without` was rejected."""
    with Dataset.open(folder, made) as dataset:
        for shard in dataset.pending():
            rows, rejected = filling(made, shard)
            if shard.task.spec.name == without:
                lost = (Rejected(r["task"], r["index"], 0, r["engine"], "crashed", "died twice") for r in rows)
                rows, rejected = [], [*rejected, *lost]
            dataset.write(shard, rows, rejected)
        dataset.finish()


def test_a_task_without_questions_does_not_spoil_the_others(tmp_path: Path) -> None:
    empty(tmp_path / "out", plan(), "collide")
    front = yaml.safe_load((tmp_path / "out/README.md").read_text().split("---")[1])
    assert [c["config_name"] for c in front["configs"]] == ["all", "motion_speed"]
    rows = datasets.load_dataset(str(tmp_path / "out"), "motion_speed", split="test", cache_dir=str(tmp_path / "cache"))
    assert len(rows) == sum(len(filling(plan(), s)[0]) for s in plan().shards() if s.task.spec.name == "motion_speed")
    assert "crashed" in (tmp_path / "out/README.md").read_text()


def test_card_has_loading_code_and_rejections(made: Path) -> None:
    card = (made / "README.md").read_text()
    front = yaml.safe_load(card.split("---")[1])
    assert (front["configs"][0]["config_name"], front["configs"][0]["default"]) == ("all", True)
    assert front["configs"][1] == {
        "config_name": "collide",
        "data_files": [{"split": "test", "path": "data/collide/test-*.parquet"}],
    }
    assert front["license"] == ["cc-by-4.0", "unknown"]
    for said in (
        "load_dataset(",
        "0.8, 1, 1.2 (m/s)",
        "two options look the same",
        "Licence of the spec: CC-BY-4.0",
        "![The pictures and options of one question of collide](examples/collide.webp)",
        "lossless WebP",
        "@misc{wmspec-",
    ):
        assert said in card
    assert Image.open(made / "examples/collide.webp").width == 1000


def test_the_data_have_the_licence_that_is_chosen(made: Path) -> None:
    before = contents(made)
    licensed = replace(plan(), licence="CC0-1.0")
    make(made, licensed)
    after = contents(made)
    assert [name for name in before if before[name] != after[name]] == ["README.md", "croissant.json", "manifest.json"]
    assert yaml.safe_load((made / "README.md").read_text().split("---")[1])["license"] == ["cc0-1.0"]
    assert json.loads((made / "croissant.json").read_bytes())["license"] == ["CC0-1.0"]


def test_card_names_the_engine_and_the_renderer(made: Path) -> None:
    total, alone = make_summary(made), replace(plan(), engines=("mujoco",), renderer="sapien")
    said = card(alone, total, {})
    assert "executed in mujoco and drawn by sapien" in said
    assert "One engine executed it" in said
    assert "all engines agree" not in said
    assert "in one engine." in said


def make_summary(folder: Path) -> Summary:
    with Dataset.open(folder, plan()) as dataset:
        return dataset.finish()


def test_nothing_is_left_of_the_making(made: Path) -> None:
    names = {p.name for p in made.iterdir()}
    assert names == {"data", "examples", "README.md", "croissant.json", "manifest.json", "plan.json"}
    with pytest.raises(WmsError, match="another dataset"):
        Dataset.open(made, plan(seed=8))
    assert {p.name for p in made.iterdir()} == names


def test_a_finished_dataset_that_loses_a_shard_is_known_by_its_manifest(made: Path, whole: dict[str, bytes]) -> None:
    lost = made / "data/collide/test-00001-of-00003.parquet"
    lost.unlink()
    with Dataset.open(made, plan()) as dataset:
        assert [str(made / s.path) for s in dataset.pending()] == [str(lost)]
    with Dataset.open(made, plan()) as dataset:  # stopped, and begun again
        assert len(dataset.pending()) == 1
    make(made, plan())
    assert contents(made) == whole
