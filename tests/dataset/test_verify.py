"""A dataset is made again from its manifest: the same comes out, and what was altered is named."""

from __future__ import annotations

import hashlib
import io
import json
import re
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from PIL import Image

from tests.command import wmspec
from tests.endtoend.test_commands import SPEED
from tests.engines import installed
from wmspec.api import generate
from wmspec.api.verifying import verify
from wmspec.core.diagnostics import WmsError
from wmspec.dataset.build.images import encode_png
from wmspec.dataset.build.reader import DatasetReader
from wmspec.dataset.build.shards import parquet
from wmspec.eval.models.question import Selection, questions


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    installed("mujoco")
    folder = tmp_path_factory.mktemp("verify") / "out"
    generate(SPEED, folder, per_task=3, backend="mujoco", size=64, workers=0)
    return folder


def altered(made: Path, folder: Path, change: Callable[[dict[str, Any]], object]) -> Path:
    """The dataset with its first row changed, as if it had been made so."""
    shutil.copytree(made, folder)
    path = next(folder.glob("data/*/*.parquet"))
    table = pq.read_table(path)
    rows = table.to_pylist()
    change(rows[0])
    path.write_bytes(parquet(pa.Table.from_pylist(rows, schema=table.schema)))
    manifest = json.loads((folder / "manifest.json").read_bytes())
    manifest["shards"][path.relative_to(folder).as_posix()]["sha256"] = hashlib.sha256(path.read_bytes()).hexdigest()
    (folder / "manifest.json").write_text(json.dumps(manifest))
    return folder


def noisy(row: dict[str, Any]) -> None:
    pixels = np.asarray(Image.open(io.BytesIO(row["context"][0]["bytes"])))
    row["context"][0]["bytes"] = encode_png((pixels ^ (np.arange(64) == 0)[:, None, None]).astype(np.uint8))


def former(made: Path, folder: Path) -> Path:
    """The dataset as format 2 had it: ids that name the instance and the engine."""

    def named(row: dict[str, Any]) -> None:
        row["id"] = f"{row['task']}/{row['index']:06d}/q{row['question']}/{row['engine']}"

    altered(made, folder, named)
    manifest = json.loads((folder / "manifest.json").read_bytes())
    (folder / "manifest.json").write_text(json.dumps(manifest | {"format": 2}))
    (folder / "plan.json").unlink()
    return folder


def test_former_format_is_read_and_not_written(made: Path, tmp_path: Path) -> None:
    folder = former(made, tmp_path / "former")
    dataset = DatasetReader.open(folder)
    ids = Selection().ids(dataset)
    assert [q.id for q in questions(dataset, ids)] == ids
    assert ids[0].count("/") == 3
    with pytest.raises(WmsError, match=r"has format 2; this version makes format \d.*pip install wmspec=="):
        verify(folder, workers=0)


def test_rerun_gives_the_same(made: Path) -> None:
    result = verify(made, sample=2, workers=0)
    assert (result.planned, result.verdict, result.differences) == (3, "same", ())
    assert result.questions in (2, 3), "two rows, and one of each task"
    assert not result.versions
    assert verify(made, sample=2, sample_seed=result.sample_seed, workers=0) == result


@pytest.mark.parametrize("plan", ["[]", "{", None])
def test_a_dataset_without_its_plan_differs_in_that_file_alone(made: Path, tmp_path: Path, plan: str | None) -> None:
    folder = tmp_path / "copied"
    shutil.copytree(made, folder)
    (folder / "plan.json").unlink()
    if plan is not None:
        (folder / "plan.json").write_text(plan)
    assert [difference.id for difference in verify(folder, sample=1, workers=0).differences] == ["plan.json"]


def test_altered_files_are_named(made: Path, tmp_path: Path) -> None:
    def other(row: dict[str, Any]) -> None:
        row["answer"] = (row["answer"] + 1) % len(row["option_text"])

    folder = altered(made, tmp_path / "other", other)
    reported = wmspec("verify", folder, "--all", "-j", 1, folder=tmp_path, code=1).stdout
    assert "DIFFERENT speed_tabletop/" in reported
    assert ": answer: " in reported
    assert re.search(r"3 of 3 questions generated again: \d different", reported)


def test_near_equality_passes_and_is_reported(made: Path, tmp_path: Path) -> None:
    folder = altered(made, tmp_path / "near", noisy)
    result = verify(folder, every=True, other_machine=True, workers=0)
    difference = next(one for one in result.differences if one.column)
    assert verify(folder, every=True, workers=0).verdict == "different", "the versions are the same"
    assert difference.column == "context"
    assert difference.words.startswith("picture 1 differs in 1.56% of its values, by 0.016 ")


def test_a_damaged_dataset_is_not_verified(made: Path, tmp_path: Path) -> None:
    shutil.copytree(made, tmp_path / "damaged")
    next((tmp_path / "damaged").glob("data/*/*.parquet")).write_bytes(b"PAR1")
    with pytest.raises(WmsError, match="was modified"):
        verify(tmp_path / "damaged", workers=0)
