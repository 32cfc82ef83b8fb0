"""Every manner of replying has its outcome, its score and its printed cause, equal in `evaluate` and `report`."""

from __future__ import annotations

import json
import os
import subprocess
from pathlib import Path
from typing import Any
from urllib.parse import quote

import pyarrow.parquet as pq
import pytest
from click.testing import CliRunner

from tests.evaluate.made import in_words
from tests.evaluate.manners import MANNERS, Response, always, chat, error, first_words, server
from tests.evaluate.test_export import INSPECT
from wmspec.cli import main

pytest.importorskip("openai")

Row = dict[str, Any]
KEY = "sk-Key/With+odd=Signs-0123456789"


@pytest.fixture(scope="module")
def dataset(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return in_words(tmp_path_factory.mktemp("words"), 2)


def run(*args: object) -> str:
    done = CliRunner().invoke(main, list(map(str, args)), env={"OPENAI_API_KEY": "sk-secret"})
    assert done.exit_code in (0, 1), done.output
    return done.output


def evaluate(name: str, dataset: Path, out: Path, address: str, *more: object) -> str:
    args = ("--base-url", address, "-o", out, "--retries", 2, "--timeout", 1, *more)
    return run("evaluate", dataset, "-m", f"openai:{name.replace(' ', '_')}", *args)


#: The report sees what differs between their rows: the first manner of each outcome and cause.
REPORTED = {(manner.outcome, manner.cause): name for name, manner in reversed(MANNERS.items())}.values()


def test_there_are_many_manners() -> None:
    assert len(MANNERS) >= 30
    assert {manner.outcome for manner in MANNERS.values()} == {"answered", "unparsed", "truncated", "refused", "error"}


@pytest.fixture(scope="module")
def printed(dataset: Path, tmp_path_factory: pytest.TempPathFactory) -> dict[str, tuple[Path, str]]:
    """The results of every manner, and what `evaluate` prints."""
    folder = tmp_path_factory.mktemp("results")
    with server(first_words) as running:
        paths = {name: folder / f"{name.replace(' ', '_')}.parquet" for name in MANNERS}
        return {name: (path, evaluate(name, dataset, path, running.address)) for name, path in paths.items()}


@pytest.fixture(scope="module")
def reported(
    dataset: Path, printed: dict[str, tuple[Path, str]], tmp_path_factory: pytest.TempPathFactory
) -> tuple[dict[str, Any], str]:
    """The report on those manners, and what it prints."""
    folder = tmp_path_factory.mktemp("report")
    said = run("report", *(printed[name][0] for name in REPORTED), "--dataset", dataset, "-o", folder)
    return json.loads((folder / "report.json").read_text()), said


@pytest.mark.parametrize("name", MANNERS)
def test_a_manner_has_its_outcome_score_and_cause(name: str, printed: dict[str, tuple[Path, str]]) -> None:
    manner, (out, output) = MANNERS[name], printed[name]
    rows: list[Row] = pq.read_table(out).to_pylist()
    assert len(rows) == 4
    assert {row["status"] for row in rows} == {manner.outcome}
    assert {row["answer"] for row in rows} == {0, 1}
    for row in rows:
        assert row["parsed"] == (0 if manner.outcome == "answered" else None)
        assert row["right"] == (manner.outcome == "answered" and row["answer"] == 0)
    right = sum(row["right"] for row in rows)
    assert f"4 replies, {right} right" in output
    causes = [line for line in output.splitlines() if line.startswith(f"4 {manner.outcome}, ")]
    assert [line.partition(" (such as")[0] for line in causes] == (
        [f"4 {manner.outcome}, {manner.cause}"] if manner.cause else []
    )
    assert manner.note in output


@pytest.mark.parametrize("name", REPORTED)
def test_the_report_has_the_outcome_score_and_cause(
    name: str, printed: dict[str, tuple[Path, str]], reported: tuple[dict[str, Any], str]
) -> None:
    manner, (out, output), (made, said) = MANNERS[name], printed[name], reported
    right = sum(pq.read_table(out)["right"].to_pylist())
    causes = [line for line in output.splitlines() if line.startswith(f"4 {manner.outcome}, ")]
    model = f"openai:{name.replace(' ', '_')}"
    lines = [line for line in said.splitlines() if line.startswith(f"{model}: 4 ")]
    assert [line.removeprefix(f"{model}: ") for line in lines] == causes
    (account,) = [account for account in made["accounts"] if account["system"] == model]
    assert {outcome: account[outcome] for outcome in ("answered", "unparsed", "truncated", "refused", "error")} == {
        outcome: 4 * (outcome == manner.outcome)
        for outcome in ("answered", "unparsed", "truncated", "refused", "error")
    }
    (line,) = [line for line in made["tables"][0]["lines"] if line["system"] == model]
    assert line["average"]["value"] == pytest.approx(right / 4)
    assert line["average"]["questions"] == 4


def test_reasoning_and_its_tokens_are_kept(dataset: Path, tmp_path: Path) -> None:
    for name in ("reasoning field", "thinking parts"):
        out = tmp_path / f"{name}.parquet"
        with server(first_words) as running:
            evaluate(name, dataset, out, running.address, "--limit", 1)
        (row,) = pq.read_table(out).to_pylist()
        assert row["reasoning"].startswith("The answer is A" if "field" in name else "A or B")
        assert (row["tokens_reasoning"], row["finish_reason"], row["text"]) == (7, "stop", "A")


def test_a_quota_that_is_used_up_ends_the_run(dataset: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    spent = always(error(429, "You exceeded your current quota.", "insufficient_quota"))
    monkeypatch.setitem(MANNERS, "quota", spent)
    with server(first_words) as running:
        args = (
            "-m",
            "openai:quota",
            "--base-url",
            running.address,
            "-o",
            str(tmp_path / "r.parquet"),
            "--retries",
            "0",
        )
        done = CliRunner().invoke(main, ["evaluate", str(dataset), *args], env={"OPENAI_API_KEY": "sk-secret"})
    assert done.exit_code == 2
    assert "the quota is used up" in done.output
    assert "sk-secret" not in done.output


@pytest.mark.parametrize(
    "response",
    [
        chat("A", KEY),
        chat("A", reasoning_content=f"{KEY} {KEY}"),
        chat([{"type": "text", "text": f"A {KEY}"}]),
        chat(None, refusal="x" * 1990 + KEY),
        error(500, "x" * 1960 + KEY),
        error(400, json.dumps(KEY).replace("/", "\\/")),
        error(400, quote(KEY, safe=""), "content_filter"),
        (200, json.dumps(KEY).encode()),
    ],
)
def test_no_part_of_an_echoed_key_is_written(
    response: Response, dataset: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(MANNERS, "echo", always(response))
    with server(first_words) as running:
        args = ["-m", "openai:echo", "--base-url", running.address, "-o", tmp_path / "r.parquet", "--limit", 1]
        args += ["--cache", tmp_path / "cache", "--retries", 0]
        done = CliRunner().invoke(main, ["evaluate", str(dataset), *map(str, args)], env={"OPENAI_API_KEY": KEY})
    written = [path.read_bytes() for path in tmp_path.iterdir()] + [done.output.encode()]
    written.append(repr(pq.read_table(tmp_path / "r.parquet").to_pylist()).encode())
    assert not [content for content in written if KEY[:12].encode() in content]


@pytest.mark.parametrize(("key", "code"), [(f" {KEY}\n", 0), (f"{KEY}\n{KEY}", 2), (f"{KEY}ä", 2)])
def test_a_key_is_stripped_or_refused_without_its_text(key: str, code: int, dataset: Path, tmp_path: Path) -> None:
    with server(first_words) as running:
        args = ("-m", "openai:right", "--base-url", running.address, "-o", str(tmp_path / "r.parquet"), "--limit", "1")
        done = CliRunner().invoke(main, ["evaluate", str(dataset), *args], env={"OPENAI_API_KEY": key})
    assert done.exit_code == code, done.output
    assert ("OPENAI_API_KEY has characters that no key has" in done.output) == bool(code)
    assert KEY[:12] not in done.output


def test_a_placeholder_is_no_key(dataset: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Local servers need no key, and `none` is a word of replies."""
    monkeypatch.setitem(MANNERS, "none", always(chat("none of the others, so A")))
    with server(first_words) as running:
        args = ("-m", "openai:none", "--base-url", running.address, "-o", tmp_path / "r.parquet", "--limit", 1)
        CliRunner().invoke(main, ["evaluate", str(dataset), *map(str, args)], env={"OPENAI_API_KEY": "none"})
    assert pq.read_table(tmp_path / "r.parquet")["text"].to_pylist() == ["none of the others, so A"]


def test_a_parameter_that_the_user_chose_is_not_left_out(dataset: Path, tmp_path: Path) -> None:
    with server(first_words) as running:
        printed = evaluate("new names", dataset, tmp_path / "r.parquet", running.address, "-p", "temperature=0.5")
    assert "4 error, BadRequestError: Error code: 400" in printed
    assert "'temperature' does not support 0" in printed


def test_one_request_learns_for_all(dataset: Path, tmp_path: Path) -> None:
    with server(first_words) as running:
        evaluate("new names", dataset, tmp_path / "r.parquet", running.address, "--concurrency", 1)
        assert sum(running.tries.values()) == 4 + 2
    noted = json.loads((tmp_path / "r.json").read_text())["notes"]
    assert any("`temperature`" in note for note in noted)


@pytest.mark.slow
@pytest.mark.skipif(not INSPECT.exists(), reason="Inspect has an environment of its own: make inspect")
@pytest.mark.parametrize("way", sorted({manner.in_inspect for manner in MANNERS.values()}), ids=" ".join)
def test_inspect_has_the_same_outcomes(way: tuple[str, ...], dataset: Path, tmp_path: Path) -> None:
    run("export", dataset, "--to", "inspect", "-o", tmp_path / "x")
    provider, *options = way
    names = [name for name, manner in MANNERS.items() if manner.in_inspect == way]
    models = {f"{provider}/{name.replace(' ', '_')}": name for name in names}
    with server(first_words) as running:
        env = {"LOOPBACK_BASE_URL": running.address, "LOOPBACK_API_KEY": "none", "PATH": os.environ["PATH"]}
        env |= {"MISTRAL_BASE_URL": running.address.removesuffix("/v1"), "MISTRAL_API_KEY": "none"}
        command = [INSPECT, "eval", "wmspec_task.py", "--model", ",".join(models), "--max-tasks", "8", *options]
        command += ["--display", "none", "--log-format", "json", "--no-log-realtime"]
        command += ["--max-retries", "3", "--timeout", "30", "--attempt-timeout", "2"]
        subprocess.run([*map(str, command)], cwd=tmp_path / "x", env=env | {"HOME": str(tmp_path)}, check=True)
    logs = [json.loads(log.read_text()) for log in (tmp_path / "x/logs").glob("*.json")]
    samples = {models[log["eval"]["model"]]: log["samples"] for log in logs}
    assert set(samples) == set(names)
    marks = {name: [sample["scores"]["right"] for sample in samples[name]] for name in names}
    outcomes = {name: {mark["metadata"]["outcome"] for mark in marks[name]} for name in names}
    assert outcomes == {name: {MANNERS[name].outcome} for name in names}
    answers = {name: {mark.get("answer") for mark in marks[name]} for name in names}
    assert answers == {name: {"0" if outcomes[name] == {"answered"} else None} for name in names}
