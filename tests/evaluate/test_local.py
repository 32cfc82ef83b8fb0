"""A model of weights on this machine is asked as any other."""

from __future__ import annotations

from pathlib import Path

import pyarrow.parquet as pq
import pytest
from click.testing import CliRunner

from tests.evaluate import tiny
from tests.evaluate.made import in_pictures
from wmspec.cli import main

pytestmark = pytest.mark.slow
pytest.importorskip("torch", reason="local models need torch: pip install 'wmspec[local]'")
pytest.importorskip("transformers", reason="local models need transformers: pip install 'wmspec[local]'")


def evaluate(*args: object, code: int = 0) -> str:
    done = CliRunner().invoke(main, ["evaluate", *map(str, args)])
    assert done.exit_code == code, done.output
    return done.output


def test_local_weights_reply_and_identify_themselves(tmp_path: Path) -> None:
    dataset, model = in_pictures(tmp_path / "d", 2), tiny.make(tmp_path / "tiny")
    args = (dataset, "-m", f"hf:{model}", "-p", "max_tokens=4")
    for name in ("default", "montage"):
        evaluate(*args, "-o", tmp_path / f"{name}.parquet", "--prompt", name)
    rows = pq.read_table(tmp_path / "default.parquet").to_pylist()
    assert len(rows) == 4
    for row in rows:
        assert row["status"] in {"answered", "unparsed", "truncated"}, row["error"]
        assert row["text"]
        assert row["tokens_in"] > 6 * 16, "every picture is 16 tokens"
        assert 1 <= row["tokens_out"] <= 4
        assert row["model_version"].startswith("llava:")
    again = tmp_path / "again.parquet"
    evaluate(*args, "-o", again)
    assert [row["text"] for row in pq.read_table(again).to_pylist()] == [row["text"] for row in rows]


def test_unreadable_or_unshowable_datasets_are_errors(tmp_path: Path) -> None:
    dataset = in_pictures(tmp_path / "d", 2)
    assert "no config.json" in evaluate(dataset, "-m", f"hf:{tmp_path}", "-o", tmp_path / "r.parquet", code=2)
    (tmp_path / "bad").mkdir()
    (tmp_path / "bad/config.json").write_text("{}")
    assert "cannot open it" in evaluate(dataset, "-m", f"hf:{tmp_path / 'bad'}", "-o", tmp_path / "r.parquet", code=2)
