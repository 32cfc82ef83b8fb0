"""One row for each question: no command and no model meets the same question once for each engine.

Datasets of earlier formats, which have a row for each engine, open everywhere.
"""

from __future__ import annotations

import json
import shutil
from collections import Counter
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import pyarrow.parquet as pq
import pytest

from tests.command import wmspec
from tests.endtoend.conftest import OPTIONS, SHOVE
from tests.endtoend.test_commands import SPEED
from tests.endtoend.test_datasets import digests
from tests.evaluate.loopback import loopback
from wmspec.api import generate
from wmspec.api.attesting import attest
from wmspec.api.generating import DatasetOptions
from wmspec.api.verifying import verify
from wmspec.dataset.build.reader import DatasetReader

ENGINES = {"mujoco", "pybullet", "sapien"}
OLD = Path(__file__).parent.parent / "data/format_2"


@pytest.fixture
def old(tmp_path: Path) -> Path:
    return Path(shutil.copytree(OLD, tmp_path / "old"))


def rows(dataset: Path) -> list[dict[str, Any]]:
    opened = DatasetReader.open(dataset)
    return [row for task in opened.tasks for row in opened.rows(task)]


def once(questions: Iterable[tuple[object, ...]], expected: Path) -> None:
    """Assert that these are the questions of a dataset, each of them once."""
    counts = Counter(questions)
    assert set(counts.values()) == {1}
    assert set(counts) == {key(row) for row in rows(expected)}


def key(row: dict[str, Any]) -> tuple[object, ...]:
    return row["task"], row["index"], row["question"]


def evaluated(dataset: Path, folder: Path, *options: object) -> tuple[list[dict[str, Any]], list[str], str]:
    """Evaluate a model; return its results, the requests that the server received, and the messages."""
    pytest.importorskip("openai")
    with loopback() as server:
        address = ("--base-url", server.address, "-o", "results.parquet")
        done = wmspec(
            "evaluate", dataset, "-m", "openai:first", *address, *options, folder=folder, OPENAI_API_KEY="none"
        )
        requests = [json.dumps(body["messages"], sort_keys=True) for body in server.bodies]
    return pq.read_table(folder / "results.parquet").to_pylist(), requests, done.stderr


def test_a_row_has_the_answers_of_all_engines(dataset: Path) -> None:
    once(map(key, rows(dataset)), dataset)
    for row in rows(dataset):
        assert {vote["engine"] for vote in row["agreement"]} == ENGINES


def test_model_gets_each_question_once(dataset: Path, tmp_path: Path) -> None:
    results, requests, messages = evaluated(dataset, tmp_path)
    known = {row["id"]: key(row) for row in rows(dataset)}
    once((known[result["id"]] for result in results), dataset)
    assert len(requests) == len(set(requests)) == len(known)
    assert "each engine" not in messages

    reported = json.loads(wmspec("report", "results.parquet", "--dataset", dataset, "--json", folder=tmp_path).stdout)
    (account,) = reported["accounts"]
    assert (account["questions"], account["replies"]) == (len(known), len(known))


def assert_shown_once(study: dict[str, Any], dataset: Path) -> None:
    """The items are questions, each once, and checks of attention."""
    known = {row["id"]: key(row) for row in rows(dataset)}
    shown = [known[item["id"]] for item in study["items"] if not item["id"].startswith("check/")]
    assert shown
    assert len(shown) == len(set(shown))


def test_people_see_a_question_once(dataset: Path, tmp_path: Path) -> None:
    wmspec("study", "make", dataset, "-o", "study", "--per-task", 2, "--raters", 2, folder=tmp_path)
    study = json.loads((tmp_path / "study/study.json").read_text())
    assert_shown_once(study, dataset)


def test_a_page_shows_a_question_once(dataset: Path, tmp_path: Path) -> None:
    wmspec("view", dataset, "-o", "page.html", folder=tmp_path)
    text = (tmp_path / "page.html").read_text()
    data = json.loads(text.split('<script type="application/json" id="data">')[1].split("</script>")[0])
    numbers = (int(q["id"].partition("/q")[2] or 0) for q in data["questions"])
    once(((q["task"], q["index"], n) for q, n in zip(data["questions"], numbers, strict=True)), dataset)
    assert all(len(question["runs"]) == 1 for question in data["questions"])
    assert all({vote[0] for vote in q["runs"][0]["votes"]} == ENGINES for q in data["questions"])


def test_an_export_has_a_question_once(dataset: Path, tmp_path: Path) -> None:
    wmspec("export", dataset, "--to", "hf", "-o", "exported", folder=tmp_path)
    files = sorted((tmp_path / "exported").rglob("*.parquet"))
    ids = [i for file in files for i in pq.read_table(file, columns=["id"])["id"].to_pylist()]
    assert sorted(ids) == sorted(row["id"] for row in rows(dataset))


def test_an_audit_counts_a_question_once(dataset: Path, tmp_path: Path) -> None:
    audit = json.loads(wmspec("audit", dataset, "--json", folder=tmp_path, code=1).stdout)  # `shove` is legible in part
    assert audit["about"]["rows"] == len(rows(dataset))
    assert {f["verdict"] for f in audit["findings"] if f["check"] == "duplicates"} == {"holds"}


def test_it_is_verified_and_attested(dataset: Path, tmp_path: Path) -> None:
    assert verify(dataset, sample=1, workers=0).verdict == "same"
    attest(dataset, tmp_path / "seal", workers=0)
    wmspec("attest", dataset, "--check", "seal/seal.json", folder=tmp_path)


def test_shares_of_machines_come_together(dataset: Path, tmp_path: Path) -> None:
    parts = tmp_path / "part-1", tmp_path / "part-2"
    for number, part in enumerate(parts, 1):
        share: DatasetOptions = {**OPTIONS, "part": (number, 2)}
        generate([SPEED, SHOVE], part, workers=0, **share)
    generate([SPEED, SHOVE], tmp_path / "merged", reuse=parts, workers=0, **OPTIONS)
    assert digests(tmp_path / "merged") == digests(dataset)


@pytest.mark.slow
def test_a_ray_cluster_makes_the_same_rows(dataset: Path, tmp_path: Path) -> None:
    pytest.importorskip("ray")
    generate([SPEED, SHOVE], tmp_path / "ray", executor="ray", **OPTIONS)
    assert digests(tmp_path / "ray") == digests(dataset)


# ---------------------------------------------------------------- one row for each engine


def test_an_old_dataset_opens_everywhere(old: Path, tmp_path: Path) -> None:
    opened = DatasetReader.open(old)
    assert (opened.manifest["format"], opened.rows_of) == (2, "engines")
    assert Counter(map(key, rows(old))) == Counter(
        {("speed_tabletop", i, 0): 3 for i in {r["index"] for r in rows(old)}}
    )
    wmspec("view", old, "-o", "page.html", folder=tmp_path)
    wmspec("view", old, "-o", "sheet.png", folder=tmp_path)
    wmspec("audit", old, "--json", folder=tmp_path, code=1)  # two instances have few answers
    wmspec("export", old, "--to", "hf", "-o", "exported", folder=tmp_path)
    wmspec("study", "make", old, "-o", "study", "--per-task", 1, "--raters", 1, folder=tmp_path)
    study = json.loads((tmp_path / "study/study.json").read_text())
    assert_shown_once(study, old)


def test_questions_of_several_engines_are_announced(old: Path, tmp_path: Path) -> None:
    results, requests, messages = evaluated(old, tmp_path)
    assert len(results) == len(requests) == 6
    assert "a row for each engine, and each question is asked 3 times" in messages
    assert "--engine mujoco" in messages
    (tmp_path / "results.parquet").unlink()
    results, _, messages = evaluated(old, tmp_path, "--engine", "mujoco")
    assert len(results) == 2
    assert "each engine" not in messages
    wmspec("report", "results.parquet", "--dataset", old, "--json", folder=tmp_path)
