"""An untrusted dataset: faults are reported in a sentence, and nothing is written outside the named folder."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from tests.dataset.made import make, plan
from tests.dataset.test_dataset import contents
from tests.trust.made import below, edited, png, rewritten, signed, wmspec
from wmspec.core.diagnostics import WmsError
from wmspec.dataset.build.dataset import Dataset
from wmspec.dataset.build.reader import DatasetReader
from wmspec.dataset.build.reuse import PriorInstances

SHARD = "data/collide/test-00000-of-00003.parquet"
Change = Callable[[list[dict[str, Any]]], None]


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("whole") / "data set"
    make(folder, plan())
    return folder


@pytest.fixture
def folder(tmp_path: Path, whole: Path) -> Path:
    shutil.copytree(whole, tmp_path / "in")
    return tmp_path / "in"


def setting(name: str, value: Any) -> Change:
    def change(rows: list[dict[str, Any]]) -> None:
        rows[1][name] = value

    return change


def pictured(content: bytes) -> Change:
    return lambda rows: rows[1]["context"][0].update(bytes=content)


@pytest.mark.parametrize(
    ("change", "reported"),
    [
        (setting("task", "../../out"), "row 2: its task is `../../out`"),
        (setting("engine", "/tmp/x"), "row 2: its engine is `/tmp/x`"),
        (setting("renderer", "../x"), "row 2: its renderer is `../x`, which is not a name"),
        (setting("text", None), "row 2: `text` is null"),
        (setting("measured", [{"name": None, "value": 1.0}]), "row 2: `name` of `measured` is null"),
        (setting("measured", [{"name": "speed(ball)", "value": None}]), "row 2: `value` of `measured` is null"),
        (setting("index", -1), "row 2: its index is -1"),
        (setting("answer", 9), "row 2: its answer is 9, of 4 options"),
        (setting("answer", None), "row 2: its answer is None, of 4 options"),
        (setting("context_camera", []), "row 2: it has 3 context, 0 context_camera"),
        (setting("option_image", []), "row 2: it has 4 options, 0 with a text and 0 with a picture"),
        (pictured(b"<script>"), "row 2: picture 1 of `context` is no PNG"),
    ],
)
@pytest.mark.parametrize("output", ["page.html", "folder", "sheet.png"])
def test_rows_that_are_not_rows(tmp_path: Path, folder: Path, change: Change, reported: str, output: str) -> None:
    rewritten(folder, SHARD, change)
    before = below(tmp_path)
    result = wmspec("view", folder, "-o", tmp_path / "out" / output if output == "folder" else tmp_path / output)
    assert result.exit_code == 2
    assert f"{SHARD}: {reported}" in result.output
    assert all(path.is_relative_to(tmp_path / "out") for path in below(tmp_path) - before)


@pytest.mark.parametrize("content", [png(64)[:-200], png(64)[:8] + b"no more", png(64)[:60]])
@pytest.mark.parametrize("output", ["page.html", "folder", "sheet.png"])
def test_pictures_that_are_cut_off(tmp_path: Path, folder: Path, content: bytes, output: str) -> None:
    rewritten(folder, SHARD, pictured(content))
    result = wmspec("view", folder, "-o", tmp_path / output)
    assert result.exit_code == 2
    assert "cannot be read: it is damaged, or no PNG" in result.output


def test_a_task_whose_name_leads_out(tmp_path: Path, folder: Path) -> None:
    """What `view` wrote under `pictures/{task}` went to wherever the manifest said."""
    (folder / "data/collide").rename(tmp_path / "evil")

    def renamed(manifest: dict[str, Any]) -> None:
        manifest["tasks"]["../../evil"] = manifest["tasks"].pop("collide")

    edited(folder, renamed)
    before = below(tmp_path)
    result = wmspec("view", folder, "-o", tmp_path / "out" / "deep")
    assert result.exit_code == 2
    assert "manifest.json is not a manifest of `wmspec generate`: `tasks.../../evil" in result.output
    assert below(tmp_path) == before


@pytest.mark.parametrize(
    ("change", "reported"),
    [
        (lambda m: m.update(rows=3), "it counts 3 rows"),
        (lambda m: m.update(rows="many"), "`rows`: input should be a valid integer"),
        (lambda m: m["tasks"]["collide"].update(rows={"mujoco": 1}), "it counts 1 rows of `collide`"),
        (lambda m: m["tasks"].pop("collide"), "it has files of `collide`, which is none of its tasks"),
        (lambda m: m["shards"].update({"data/../../x.parquet": {"rows": 0, "sha256": "0" * 64}}), "`shards."),
        (lambda m: m["rejected"].update(list=[]), "its rejections are not those that it counts"),
        (lambda m: m.update(engines=[]), "`engines`"),
        (lambda m: m.update(seed=8), "is not of the dataset that"),
        (lambda m: m.update(fingerprint="0" * 64), "is not of the dataset that"),
    ],
)
@pytest.mark.parametrize("command", ["view", "audit"])
def test_a_manifest_that_was_edited(tmp_path: Path, folder: Path, change: Any, reported: str, command: str) -> None:
    edited(folder, change)
    result = wmspec(command, folder, "-o", tmp_path / "out")
    assert result.exit_code == 2
    assert reported in result.output


def test_every_reader_of_the_folder_reports_an_extra_file(tmp_path: Path, folder: Path) -> None:
    foreign = "data/collide/test-00003-of-00004.parquet"
    shutil.copy(folder / SHARD, folder / foreign)
    for command in ("view", "audit"):
        result = wmspec(command, folder, "-o", tmp_path / "out")
        assert result.exit_code != 0
        assert f"{foreign} is not part of the dataset" in result.output
    with pytest.raises(WmsError, match=f"{foreign} is not part of the dataset"):
        Dataset.open(folder, plan())
    assert (folder / foreign).exists(), "it is somebody's"


@pytest.mark.parametrize("name", ["context", "answer"])
def test_columns_of_another_type(folder: Path, name: str) -> None:
    import pyarrow as pa
    import pyarrow.parquet as pq

    table = pq.read_table(folder / SHARD)
    place = table.column_names.index(name)
    pq.write_table(table.set_column(place, name, pa.array(["x"] * len(table))), folder / SHARD)
    signed(folder, SHARD)
    with pytest.raises(WmsError, match=f"column `{name}` is string, expected"):
        list(DatasetReader.open(folder).rows("collide"))


def test_a_plan_that_was_lost_is_rebuilt(tmp_path: Path, folder: Path, whole: Path) -> None:
    lost = folder / "plan.json"
    lost.unlink()
    Dataset.open(folder, plan()).close()
    assert contents(folder) == contents(whole)


def test_a_plan_that_was_lost_is_rebuilt_for_reuse(tmp_path: Path) -> None:
    from dataclasses import replace

    ordered = plan(count=4)
    ordered = replace(ordered, tasks=tuple(replace(t, indices=tuple(sorted(t.indices))) for t in ordered.tasks))
    few = replace(ordered, tasks=tuple(replace(t, indices=t.indices[:2]) for t in ordered.tasks))
    make(tmp_path / "few", few)
    (tmp_path / "few/plan.json").unlink()
    before = PriorInstances([tmp_path / "few"], ordered)
    assert all(before.missing(s) == s.indices[len(s.indices) :] for s in few.shards())
    with pytest.raises(WmsError, match="holds no dataset that could be reused"):
        PriorInstances([tmp_path / "few"], replace(ordered, seed=8))


def test_a_factor_without_a_value_is_a_dash(tmp_path: Path, folder: Path) -> None:
    def emptied(rows: list[dict[str, Any]]) -> None:
        rows[1].update({name: None for name in rows[1] if name.startswith(("factor.", "nuisance."))})

    rewritten(folder, SHARD, emptied)
    for output in ("page.html", "folder", "sheet.png"):
        result = wmspec("view", folder, "-o", tmp_path / output)
        assert result.exit_code == 0, result.output
