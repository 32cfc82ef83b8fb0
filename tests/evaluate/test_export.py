"""Exported folders: other tools run them as they are, and come to the scores that wmspec comes to."""

from __future__ import annotations

import ast
import base64
import csv
import importlib.util
import io
import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import pyarrow.parquet as pq
import pytest
from click.testing import CliRunner, Result
from PIL import Image

from tests.evaluate.loopback import first, loopback
from tests.evaluate.made import in_numbers, in_pictures, in_words
from wmspec.cli import main
from wmspec.cli.export import TOOLS
from wmspec.eval import replies
from wmspec.eval.export.export import WRITERS
from wmspec.eval.models import prompt
from wmspec.eval.models.request import Ask, Picture, Text

Row = dict[str, Any]
MAKERS = {"words": in_words, "pictures": in_pictures, "numbers": in_numbers}

#: Inspect in an environment of its own: `make inspect` makes one.
INSPECT = Path(os.environ.get("WMSPEC_INSPECT", Path(__file__).parents[2] / "build/inspect/bin/inspect"))


@pytest.fixture(scope="module", params=MAKERS)
def dataset(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Path:
    made: Path = MAKERS[request.param](tmp_path_factory.mktemp(request.param), 6)
    return made


def wmspec(*args: object, code: int = 0) -> Result:
    done = CliRunner().invoke(main, [str(arg) for arg in args])
    assert done.exit_code == code, done.output
    return done


def score(dataset: Path, folder: Path) -> float:
    """wmspec's own, of the server that takes the first option."""
    pytest.importorskip("openai")
    with loopback() as server:
        args = ("-m", "openai:first", "--base-url", server.address, "-o", folder / "own.parquet")
        wmspec("evaluate", dataset, *args)
    rows = pq.read_table(folder / "own.parquet").to_pylist()
    return sum(row["right"] for row in rows) / len(rows)


def parser(folder: Path) -> Any:
    """The parser that lies in the folder."""
    spec = importlib.util.spec_from_file_location("wmspec_reply", folder / "wmspec_reply/__init__.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules["wmspec_reply"] = module  # where dataclasses look for it
    spec.loader.exec_module(module)
    return module


def said(row: Row) -> list[Row]:
    """The turn of an exported row, as servers are sent it."""
    return [
        {"type": "text", "text": part["text"]} if part["image"] is None else {"type": "image"}
        for part in row["content"]
    ]


def test_the_command_offers_every_format() -> None:
    assert set(TOOLS) == {*WRITERS, "questions", "video", "physics-iq"}


def test_datasets_library_gives_the_same_score(dataset: Path, tmp_path: Path) -> None:
    datasets = pytest.importorskip("datasets")
    wmspec("export", dataset, "--to", "hf", "-o", tmp_path / "x")
    (task,) = [path.stem for path in (tmp_path / "x/data").iterdir()]
    rows = datasets.load_dataset(str(tmp_path / "x"), task, split="test", cache_dir=str(tmp_path / "cache"))
    assert isinstance(rows[0]["images"][0], Image.Image)
    truth = ("answer", "answer_number", "answer_unit", "answer_within")
    mark = parser(tmp_path / "x").mark
    right = [mark(first(said(r)), r["options"], r["labels"], *(r[name] for name in truth)).right for r in rows]
    assert sum(right) / len(right) == pytest.approx(score(dataset, tmp_path))


@pytest.mark.parametrize("name", ["default", "paper", "montage"])
def test_exported_requests_equal_those_of_evaluate(name: str, dataset: Path, tmp_path: Path) -> None:
    from tests.evaluate.test_evaluate import all_questions

    wmspec("export", dataset, "--to", "inspect", "-o", tmp_path / "x", "--prompt", name)
    (table,) = (tmp_path / "x/data").iterdir()
    rows = pq.read_table(table).to_pylist()
    for question, row in zip(all_questions(dataset), rows, strict=True):
        parts = [
            Text(part["text"]) if part["image"] is None else Picture(row["images"][part["image"]]["bytes"])
            for part in row["content"]
        ]
        request = Ask(question, prompt.load(name)).request
        assert (row["id"], row["system"], tuple(parts)) == (question.id, request.system, request.parts)


def test_a_table_as_vlmevalkit_reads_it(dataset: Path, tmp_path: Path) -> None:
    wmspec("export", dataset, "--to", "vlmevalkit", "-o", tmp_path / "x")
    (table,) = (tmp_path / "x").glob("Wmspec_*.tsv")
    csv.field_size_limit(sys.maxsize)
    with table.open(newline="") as file:
        rows = list(csv.DictReader(file, delimiter="\t"))
    right = []
    mark = parser(tmp_path / "x").mark
    for number, row in enumerate(rows):
        assert int(row["index"]) == number
        pictures = ast.literal_eval(row["image"])
        assert all(Image.open(io.BytesIO(base64.b64decode(png))).size == (48, 48) for png in pictures)
        whole = json.loads(row["wmspec"])
        options = whole["truth"]["options"]
        assert [bool(row[letter]) for letter in "ABCDEFGH"] == [place < len(options) for place in range(8)]
        assert row["answer"] == ("ABCD"[whole["truth"]["answer"]] if options else str(whole["truth"]["number"]))
        right.append(mark(first(said(whole)), **whole["truth"]).right)
    assert sum(right) / len(right) == pytest.approx(score(dataset, tmp_path))


def test_lmms_eval_has_a_file_for_every_task_and_one_for_all(dataset: Path, tmp_path: Path) -> None:
    wmspec("export", dataset, "--to", "lmms-eval", "-o", tmp_path / "x")
    (table,) = (tmp_path / "x/data").iterdir()
    assert f"test: data/{table.name}" in (tmp_path / f"x/wmspec_{table.stem}.yaml").read_text()
    assert f"- wmspec_{table.stem}\n" in (tmp_path / "x/wmspec.yaml").read_text()
    listed = json.loads((tmp_path / "x/export.json").read_text())["files"]
    assert sorted(str(p.relative_to(tmp_path / "x")) for p in (tmp_path / "x").rglob("*") if p.is_file()) == sorted(
        [*listed, "export.json"]
    )


@pytest.mark.parametrize("tool", ["inspect", "lmms-eval", "vlmevalkit", "hf"])
def test_every_export_has_the_parser_and_is_the_same_again(tool: str, tmp_path: Path) -> None:
    dataset = in_words(tmp_path / "d", 2)
    written = []
    for _ in range(2):
        wmspec("export", dataset, "--to", tool, "-o", tmp_path / "x")
        written.append({path: path.read_bytes() for path in (tmp_path / "x").rglob("*") if path.is_file()})
    assert written[0] == written[1]
    copied = {path.name: path.read_text() for path in (tmp_path / "x/wmspec_reply").glob("*.py")}
    assert copied == {path.name: path.read_text() for path in Path(replies.__file__).parent.glob("*.py")}


def test_foreign_files_and_logs_stay(tmp_path: Path) -> None:
    dataset = in_words(tmp_path / "d", 2)
    assert "files that are not an export" in wmspec("export", dataset, "--to", "hf", "-o", dataset, code=2).output
    wmspec("export", dataset, "--to", "inspect", "-o", tmp_path / "x")
    (tmp_path / "x/logs").mkdir()
    (tmp_path / "x/logs/one.eval").write_text("log")
    outside = tmp_path / "outside.txt"
    outside.write_text("stays")
    listed = json.loads((tmp_path / "x/export.json").read_text())
    (tmp_path / "x/export.json").write_text(json.dumps(listed | {"files": [*listed["files"], "../outside.txt"]}))
    wmspec("export", dataset, "--to", "hf", "-o", tmp_path / "x")
    assert not (tmp_path / "x/wmspec_task.py").exists()
    assert (tmp_path / "x/logs/one.eval").read_text() == "log"
    assert outside.read_text() == "stays"


def test_films_are_not_exported(tmp_path: Path) -> None:
    pytest.importorskip("imageio_ffmpeg")
    dataset = in_words(tmp_path / "d", 2)
    args = ("--to", "hf", "-o", tmp_path / "x", "--prompt", "clip")
    assert "videos cannot be exported" in wmspec("export", dataset, *args, code=2).output


@pytest.mark.slow
@pytest.mark.skipif(not INSPECT.exists(), reason="Inspect has an environment of its own: make inspect")
@pytest.mark.parametrize("rules", ["first", "first+chatty+429", "first+empty"])
def test_inspect_gives_the_same_score(rules: str, dataset: Path, tmp_path: Path) -> None:
    wmspec("export", dataset, "--to", "inspect", "-o", tmp_path / "x")
    with loopback() as server:
        env = {"LOOPBACK_BASE_URL": server.address, "LOOPBACK_API_KEY": "none", "PATH": os.environ["PATH"]}
        run = [
            INSPECT,
            "eval",
            "wmspec_task.py",
            "--model",
            f"openai-api/loopback/{rules}",
            "--display",
            "none",
            "--log-format",
            "json",
        ]
        subprocess.run(
            [*map(str, run), "--no-log-realtime"], cwd=tmp_path / "x", env=env | {"HOME": str(tmp_path)}, check=True
        )
    (log,) = (tmp_path / "x/logs").glob("*.json")
    header = json.loads(log.read_text())
    (scored,) = header["results"]["scores"]
    assert header["status"] == "success"
    expected = 0.0 if "empty" in rules else score(dataset, tmp_path)
    assert scored["metrics"]["accuracy"]["value"] == pytest.approx(expected)
