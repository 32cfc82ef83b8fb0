"""The released WM-ABench becomes a dataset: every answer convention, pictures in files, and clear errors."""

from __future__ import annotations

import io
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from click.testing import CliRunner, Result
from PIL import Image

from wmspec.cli import main
from wmspec.dataset.build.reader import DatasetReader

Row = dict[str, Any]


def png(tone: int) -> bytes:
    out = io.BytesIO()
    Image.fromarray(np.full((32, 48, 3), tone, np.uint8)).save(out, "PNG")
    return out.getvalue()


def release(folder: Path) -> Path:
    """Three tasks: options in words with a letter and with a position from 1, and image options from 0."""
    words = [
        {
            "source": [{"bytes": png(10 * i), "path": None}, {"bytes": png(10 * i + 5), "path": None}],
            "prompt": "Which object moves faster?",
            "choices_str_letter": ["A. red", "B. blue", "C. neither"],
            "image_choices": [],
            "answer": "ABC"[i % 3] if i % 2 else str(1 + i % 3),
        }
        for i in range(6)
    ]
    pictures = [
        {
            "source": [{"bytes": None, "path": "shown.png"}],
            "prompt": "What happens next?",
            "choices_str_letter": [],
            "image_choices": [{"bytes": png(40 * k + i), "path": None} for k in range(4)],
            "answer": str(i % 4),
        }
        for i in range(6)
    ]
    (folder / "shown.png").parent.mkdir(parents=True, exist_ok=True)
    (folder / "shown.png").write_bytes(png(3))
    write(folder / "motion_speed_tdw" / "test-00000-of-00002.parquet", words[:4])
    write(folder / "motion_speed_tdw" / "test-00001-of-00002.parquet", words[4:])
    write(folder / "mechanistic_drop.parquet", pictures)
    return folder


def write(path: Path, rows: list[Row]) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    image = pa.struct([("bytes", pa.binary()), ("path", pa.string())])
    kinds = {"source": pa.list_(image), "image_choices": pa.list_(image), "choices_str_letter": pa.list_(pa.string())}
    schema = pa.schema([(name, kinds.get(name, pa.string())) for name in rows[0]])
    pq.write_table(pa.Table.from_pylist(rows, schema=schema), path)


def wmspec(*args: object, code: int = 0) -> Result:
    done = CliRunner().invoke(main, [str(arg) for arg in args])
    assert done.exit_code == code, done.output
    return done


def test_every_question_is_a_row_with_its_answer(tmp_path: Path) -> None:
    wmspec("import", "wm-abench", release(tmp_path / "in"), "-o", tmp_path / "out")
    read = DatasetReader.open(tmp_path / "out")
    read.intact()
    assert read.tasks == ("mechanistic_drop", "motion_speed_tdw")
    words = list(read.rows("motion_speed_tdw"))
    assert [row["answer"] for row in words] == [i % 3 for i in range(6)]
    assert {tuple(row["option_text"]) for row in words} == {("red", "blue", "neither")}
    assert {row["dimension"] for row in words} == {"perception.motion"}
    assert len({row["id"] for row in words}) == len({row["block"] for row in words}) == 6
    pictures = list(read.rows("mechanistic_drop"))
    assert [row["answer"] for row in pictures] == [i % 4 for i in range(6)]
    assert all(row["option_text"] is None and len(row["option_image"]) == 4 for row in pictures)
    assert all(len(row["context"]) == 1 for row in pictures)


def test_models_are_evaluated_and_ranked_on_it(tmp_path: Path) -> None:
    wmspec("import", "wm-abench", release(tmp_path / "in"), "-o", tmp_path / "out")
    wmspec("evaluate", tmp_path / "out", "-m", "oracle", "-o", tmp_path / "oracle.parquet")
    rows = pq.read_table(tmp_path / "oracle.parquet").to_pylist()
    assert len(rows) == 12
    assert all(row["right"] for row in rows)
    assert (
        "fewer than 3 models"
        in wmspec("report", tmp_path / "oracle.parquet", "--ranks", tmp_path / "oracle.parquet", code=2).output
    )


def test_the_same_folder_gives_the_same_bytes_and_may_be_replaced(tmp_path: Path) -> None:
    release(tmp_path / "in")
    written = []
    for _ in range(2):
        wmspec("import", "wm-abench", tmp_path / "in", "-o", tmp_path / "out", "--limit", 5)
        written.append({p: p.read_bytes() for p in (tmp_path / "out").rglob("*") if p.is_file()})
    assert written[0] == written[1]


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"answer": "D"}, "which is none of 3 options"),
        ({"answer": "0"}, "which is none of 3 options"),
        ({"prompt": " "}, "`prompt` is empty"),
        ({"choices_str_letter": ["A. red"]}, "different options"),
        ({"source": [{"bytes": None, "path": None}]}, "neither bytes nor a path"),
        ({"source": [{"bytes": b"no picture", "path": None}]}, "cannot be read"),
        ({"source": [{"bytes": None, "path": "../outside.png"}]}, "leads out of the folder"),
    ],
)
def test_wrong_row_is_identified(changed: Row, message: str, tmp_path: Path) -> None:
    right = {
        "source": [{"bytes": png(1), "path": None}],
        "prompt": "Which?",
        "choices_str_letter": ["A. red", "B. blue", "C. neither"],
        "image_choices": [],
        "answer": "A",
    }
    write(tmp_path / "in/task.parquet", [right, right | changed])
    assert message in wmspec("import", "wm-abench", tmp_path / "in", "-o", tmp_path / "out", code=2).output


def test_invalid_release_is_an_error(tmp_path: Path) -> None:
    (tmp_path / "in").mkdir()
    assert "no Parquet files" in wmspec("import", "wm-abench", tmp_path / "in", "-o", tmp_path / "o", code=2).output
    pq.write_table(pa.table({"prompt": ["x"]}), tmp_path / "in/x.parquet")
    output = wmspec("import", "wm-abench", tmp_path / "in", "-o", tmp_path / "o", code=2).output
    assert "lacks the columns source, answer" in output
