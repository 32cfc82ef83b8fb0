"""A row says everything that a question says, and other people's tools read it without anything of ours."""

from __future__ import annotations

import os
from pathlib import Path

os.environ["HF_HUB_OFFLINE"] = "1"

import datasets
import mlcroissant
import numpy as np
import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from tests.dataset.made import ENGINES, make, plan, question_row, spec
from wmspec.dataset.build.columns import COLUMNS
from wmspec.dataset.build.identity import identity
from wmspec.dataset.build.images import as_png, decode_image, encode_webp, image_format
from wmspec.dataset.build.rows import encode, schema, table

SHARDS = "data/{}/test-*.parquet"


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    place = tmp_path_factory.mktemp("dataset")
    make(place, plan())
    return place


@pytest.fixture(scope="module")
def loaded(folder: Path, tmp_path_factory: pytest.TempPathFactory) -> datasets.Dataset:
    cache = str(tmp_path_factory.mktemp("cache"))
    return datasets.load_dataset(str(folder), "collide", split="test", cache_dir=cache)


def test_datasets_decodes_every_pixel(loaded: datasets.Dataset) -> None:
    assert len(loaded) > 0
    for row in loaded:
        question = question_row("collide", row["index"], row["engine"])
        for shown, picture in zip(row["context"], question.context, strict=True):
            assert np.array_equal(np.asarray(shown), picture.rgb)
        for shown, option in zip(row["option_image"], question.options, strict=True):
            assert option.picture is not None
            assert np.array_equal(np.asarray(shown), option.picture.rgb)


def test_datasets_reads_every_value(loaded: datasets.Dataset) -> None:
    row = loaded[0]
    question = question_row("collide", row["index"], row["engine"])
    assert row["id"] == identity(question.seed, "collide", question.index, 0, question.engine)
    assert row["text"] == question.text
    assert row["answer"] == question.answer
    assert row["option_kind"][row["answer"]] == "truth"
    assert row["option_text"] is None
    assert row["measured"] == [{"name": "contact(ball, victim)", "value": 1.0}]
    assert row["agreement"] == [
        {"engine": e, "answer": question.answer, "value": "said", "rejected": None, "apart": 0.001} for e in ENGINES
    ]
    assert "action push.speed: 0.8 -> 0.28" in row["option_change"]
    for name, value in question.factors.items():
        assert row[f"factor.{name}"] == value
        assert row[f"group.{name}"] == question.groups[name]
    assert row["nuisance.heading"] == question.nuisances["heading"]


def test_all_tasks_are_one_configuration(folder: Path, tmp_path: Path) -> None:
    rows = datasets.load_dataset(str(folder), split="test", cache_dir=str(tmp_path))
    assert set(rows["task"]) == {"collide", "motion_speed"}
    assert rows.column_names == list(COLUMNS)
    assert rows[0]["context"][0].size == (64, 64)
    assert datasets.get_dataset_default_config_name(str(folder)) == "all"


def test_pictures_are_kept_without_loss() -> None:
    noise = np.random.default_rng(0).integers(0, 256, (48, 48, 3), np.uint8)
    for pixels in (noise, np.tile(np.arange(48, dtype=np.uint8)[:, None, None], (1, 48, 3))):
        content = encode_webp(pixels)
        assert np.array_equal(np.asarray(decode_image(content)), pixels)
        assert np.array_equal(np.asarray(decode_image(as_png(content))), pixels)
        assert image_format(content) == "WEBP"
        assert content == encode_webp(pixels)
    assert image_format(as_png(content)) == "PNG"
    assert image_format(b"GIF89a") == ""


def test_datasets_streams_the_files_alone(folder: Path) -> None:
    files = str(folder / SHARDS.format("motion_speed"))
    rows = datasets.load_dataset("parquet", data_files=files, split="train", streaming=True)
    row = next(iter(rows))
    assert row["context"][0].size == (64, 64)
    assert row["option_image"] == []
    assert row["option_text"][row["answer"]] == row["answer_value"]


def test_every_factor_has_its_type_and_unit() -> None:
    columns = schema(spec("collide"))
    assert columns.field("factor.speed").type == pa.float64()
    assert columns.field("factor.speed").metadata == {b"unit": b"m/s", b"about": b"other"}
    assert columns.field("factor.rolls").type == pa.bool_()
    assert columns.field("factor.target").type == pa.string()
    assert columns.field("nuisance.heading").metadata == {b"unit": b"rad", b"about": b"position"}
    assert "group.heading" not in columns.names


def test_all_but_one_is_a_groupby(tmp_path: Path) -> None:
    """The instances that share `group.target` differ in the target alone, and are all that do."""
    rows = [encode(question_row("collide", i, "mujoco"), "questions") for i in range(len(spec("collide").factors) * 6)]
    pq.write_table(table(rows, schema(spec("collide"))), tmp_path / "t.parquet")
    frame = pd.read_parquet(tmp_path / "t.parquet")
    others = [c for c in map(str, frame) if c.startswith("factor.") and c != "factor.target"]
    sizes = []
    for _, group in frame.groupby("group.target"):
        assert (group[others].nunique() == 1).all()
        assert group["factor.target"].is_unique
        sizes.append(len(group))
    assert max(sizes) == 3


def test_croissant_is_valid_and_streams_pictures(folder: Path, caplog: pytest.LogCaptureFixture) -> None:
    described = mlcroissant.Dataset(str(folder / "croissant.json"))
    assert not described.metadata.issues.errors
    assert not described.metadata.issues.warnings
    assert "not standard" not in caplog.text
    records = list(described.records("collide"))
    assert len(records) == sum(pq.read_metadata(p).num_rows for p in folder.glob(SHARDS.format("collide")))
    question = question_row("collide", records[0]["collide/index"], records[0]["collide/engine"].decode())
    assert np.array_equal(np.asarray(records[0]["collide/context"][1]), question.context[1].rgb)


def test_rows_of_another_task_are_refused() -> None:
    with pytest.raises(ValueError, match=r"factor\.ball_color"):
        table([encode(question_row("collide", 1, "mujoco"), "questions")], schema(spec("motion_speed")))
