"""Files that are small and unpack to much, or make work that grows with the square of their size."""

from __future__ import annotations

import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from tests.dataset.made import make, plan
from tests.physics.scenes import body, floor, scene
from tests.trust.made import STAGE, signed, wmspec
from wmspec.core.parquet_io import batches, open_parquet, read_table
from wmspec.dataset.build.reader import DatasetReader
from wmspec.sim.scene.physics.contact import colliding_geoms
from wmspec.sim.shapes import Sphere
from wmspec.sim.usd.prims import Names

SHARD = "data/collide/test-00000-of-00003.parquet"


@pytest.fixture(scope="module")
def dataset(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("dataset") / "in"
    make(folder, plan(), size=24)
    return folder


def repeated(path: Path, column: str, count: int) -> None:
    """Repeat the first row of a file, with a text of a megabyte that the file holds once."""
    table = pa.concat_tables([pq.read_table(path).slice(0, 1)] * count).combine_chunks()
    texts = pa.DictionaryArray.from_arrays(pa.array(np.zeros(count, np.int32)), pa.array(["x" * 1_000_000]))
    pq.write_table(table.set_column(table.column_names.index(column), column, texts), path, store_schema=False)
    assert path.stat().st_size < 1_000_000


def test_results_that_unpack_to_much(tmp_path: Path, dataset: Path) -> None:
    path = tmp_path / "r.parquet"
    assert wmspec("evaluate", dataset, "-m", "random", "-o", path).exit_code == 0
    repeated(path, "text", 1_000)
    for command in (["report", path, "-o", tmp_path / "report"], ["evaluate", "--rescore", path]):
        assert wmspec(*command).exit_code == 2
    with pytest.raises(OSError, match="more than 500,000,000 bytes after unpacking"):
        read_table(path)


def test_results_without_replies(tmp_path: Path, dataset: Path) -> None:
    path = tmp_path / "r.parquet"
    assert wmspec("evaluate", dataset, "-m", "random", "-o", path).exit_code == 0
    pq.write_table(pq.read_table(path).slice(0, 0), path)
    result = wmspec("report", path, "--dataset", dataset, "-o", tmp_path / "report")
    assert result.exit_code == 2
    assert "the results have no replies" in result.output


def test_rows_of_a_dataset_come_in_batches_of_bounded_size(dataset: Path) -> None:
    repeated(dataset / SHARD, "text", 1_000)
    signed(dataset, SHARD)
    sizes = [batch.nbytes for batch in batches(open_parquet(dataset / SHARD))]
    assert sum(sizes) > 1_000_000_000
    assert max(sizes) < 100_000_000
    before = pa.total_allocated_bytes()
    for _row in DatasetReader.open(dataset).rows("collide"):
        assert pa.total_allocated_bytes() - before < 200_000_000


def test_a_file_of_too_many_rows(tmp_path: Path) -> None:
    path = tmp_path / "many.parquet"
    pq.write_table(pa.table({"x": pa.array(np.zeros(1_000_001, np.int8))}), path)
    with pytest.raises(OSError, match="more than 1,000,000 rows"):
        read_table(path)


def test_a_prim_with_many_schemas(tmp_path: Path) -> None:
    apis = ", ".join(f'"CollectionAPI:c{n}"' for n in range(900))
    stage = STAGE.format(task='"many"') + f'def Xform "x" (apiSchemas = [{apis}]) {{\n}}\n'
    (tmp_path / "many.usda").write_text(stage)
    result = wmspec("run", tmp_path / "many.usda", "-b", "mujoco")
    assert result.exit_code == 2
    assert "/x: has more than 200 API schemas; apply those that are needed" in result.output


def test_a_stage_that_cannot_be_flattened(tmp_path: Path) -> None:
    """A relationship in place of an attribute of a schema."""
    odd = 'def Xform "x" (prepend apiSchemas = ["PhysicsMassAPI"]) {\ncustom rel physics:mass = </ball>\n}\n'
    (tmp_path / "odd.usda").write_text(STAGE.format(task='"odd"') + odd)
    result = wmspec("run", tmp_path / "odd.usda", "-b", "mujoco", "-o", tmp_path / "odd.npz")
    assert result.exit_code == 2
    assert "is not an attribute" in result.output


def test_names_are_given_in_linear_time() -> None:
    begin, names = time.process_time(), Names()
    given = [names.give("/World/ball") for _ in range(20_000)]
    assert given[:3] == ["World_ball", "World_ball_2", "World_ball_3"]
    assert len(set(given)) == 20_000
    assert time.process_time() - begin < 3


def test_two_static_bodies_are_no_pair() -> None:
    before, after = ([replace(floor(), name=f"{side}{n}") for n in range(3_000)] for side in ("before", "after"))
    everything, begin = scene(*before, body("ball", Sphere(0.1)), *after), time.process_time()
    pairs = [(a.name, b.name) for a, _, b, _ in colliding_geoms(everything)]
    assert time.process_time() - begin < 2
    assert pairs == [*((b.name, "ball") for b in before), *(("ball", b.name) for b in after)]
