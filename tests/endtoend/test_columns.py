"""What a spec requests beyond pictures and labels is in the dataset, and other people's tools read it."""

import json
from pathlib import Path

import pytest

from tests.command import wmspec
from tests.engines import installed

SPEC = """
use tabletop
task far : custom {
  factor spot in [(10 cm, 0 cm), (0 cm, 10 cm)]
  object ball  { shape: sphere  size: 8 cm  color: red  on: table at spot }
  object block { shape: cube  size: 8 cm  color: blue  on: table at (-35 cm, 0) }
  action go = glide(ball, direction: away, speed: 10 cm/s) for 1 s
  observe front at [0 s, 1 s] as [rgb, depth, ids]
  question way "How far does the ball go?" {
    legibility off
    answer displacement(ball)  within 1 cm
    difference speed(ball)
  }
  question "Where is it?" { answer relation(ball, block)  options [right_of, left_of, behind, in_front_of] }
}
"""


def test_depth_ids_open_numbers_and_votes(tmp_path: Path) -> None:
    for engine in ("mujoco", "pybullet"):
        installed(engine)
    datasets = pytest.importorskip("datasets")
    import numpy as np

    (tmp_path / "far.wms").write_text(SPEC)
    args = ["-o", "out", "-b", "mujoco,pybullet", "--size", 96, "-j", 1, "--consensus", "majority"]
    wmspec("generate", "far.wms", *args, folder=tmp_path)
    files = str(tmp_path / "out/data/far/*.parquet")
    rows = list(datasets.load_dataset("parquet", data_files=files, split="train", cache_dir=str(tmp_path / "cache")))
    assert len(rows) == 4, "two questions of two instances"
    for row in rows:
        assert row["factor.spot"] in ([0.1, 0.0], [0.0, 0.1])
        assert {v["engine"] for v in row["agreement"]} == {"mujoco", "pybullet"}
        depth, ids = (np.asarray(row[column][0]) for column in ("context_depth", "context_ids"))
        assert depth.shape == ids.shape == (96, 96)
        ball = ids == row["context_names"].index("ball") + 1
        assert ball.sum() > 36
        red = np.asarray(row["context"][0])[ball].mean(axis=0)
        assert red[0] > 2 * red[2]
        assert 900 < np.median(depth[ball]) < 1800, "millimetres"
    way = next(r for r in rows if r["question_name"] == "way")
    assert (way["answer"], way["option_text"], way["option_image"]) == (None, [], [])
    assert way["answer_number"] == pytest.approx(0.1, abs=1e-6)
    assert (way["answer_unit"], way["answer_within"]) == ("m", 0.01)
    assert (way["difference"]["name"], way["difference"]["unit"]) == ("speed(ball)", "m/s")
    assert way["difference"]["value"] == pytest.approx(0.1)
    where = next(r for r in rows if r["question"] == 1)
    assert where["option_text"][where["answer"]] == "to the right of it"
    assert all(v["value"] == "to the right of it" for v in where["agreement"])
    manifest = json.loads((tmp_path / "out/manifest.json").read_text())
    assert manifest["consensus"] == "majority"
    assert "`context_depth`" in (tmp_path / "out/README.md").read_text()
    wmspec("view", "out", "-o", "sheet.png", folder=tmp_path)
    mlcroissant = pytest.importorskip("mlcroissant")
    described = mlcroissant.Dataset(str(tmp_path / "out/croissant.json"))
    assert not described.metadata.issues.errors
    record = next(iter(described.records("far")))
    assert record["far/question_name"] == b"way"
