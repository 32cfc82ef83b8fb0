"""Evaluation accounts for every reply, for any model, any server and any moment of a kill."""

from __future__ import annotations

import base64
import io
import json
import os
import random
import subprocess
import sys
import time
from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow.parquet as pq
import pytest
from click.testing import CliRunner, Result
from hypothesis import given, settings
from hypothesis import strategies as st
from PIL import Image

from tests.evaluate.loopback import TRIES, loopback
from tests.evaluate.made import in_numbers, in_pictures, in_words
from tests.examples import slow_except
from wmspec.cli import main
from wmspec.core.diagnostics import WmsError
from wmspec.dataset.build.reader import DatasetReader
from wmspec.eval.models import prompt, results
from wmspec.eval.models.journal import Journal
from wmspec.eval.models.model import Reply
from wmspec.eval.models.question import Question, questions
from wmspec.eval.models.request import Ask, Picture, Text

pytest.importorskip("openai")

SECRET = "sk-nobody-may-see-this"
LETTER = " Answer with the letter of the right option alone."
Row = dict[str, Any]


@pytest.fixture(scope="module")
def words(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return in_words(tmp_path_factory.mktemp("words"))


@pytest.fixture(scope="module")
def pictures(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return in_pictures(tmp_path_factory.mktemp("pictures"))


@pytest.fixture(scope="module")
def numbers(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return in_numbers(tmp_path_factory.mktemp("numbers"))


def evaluate(*args: object, code: int = 0, **env: str) -> Result:
    done = CliRunner().invoke(main, ["evaluate", *map(str, args)], env={"OPENAI_API_KEY": SECRET, **env})
    assert done.exit_code == code, done.output
    return done


def rows(path: Path) -> list[Row]:
    table: list[Row] = pq.read_table(path).to_pylist()
    return table


def all_questions(dataset: Path, pictures: bool = True) -> list[Question]:
    opened = DatasetReader.open(dataset)
    ids = [row["id"] for task in opened.tasks for row in opened.rows(task, ["id"])]
    return list(questions(opened, ids, pictures))


# ---------------------------------------------------------------- servers


@pytest.mark.parametrize(
    ("rules", "status", "tries"),
    [
        ("first", "answered", 1),
        ("first+chatty", "answered", 1),
        ("first+lower", "answered", 1),
        ("first+slow", "answered", 1),
        ("first+odd", "answered", 1),
        ("first+429", "answered", TRIES + 1),
        ("first+500", "answered", TRIES + 1),
        ("first+drop", "answered", TRIES + 1),
        ("first+empty", "unparsed", 1),
        ("first+refuse", "refused", 1),
        ("first+garbage", "error", 1),
        ("first+down", "error", 4),
    ],
)
def test_every_reply_is_accounted_for(rules: str, status: str, tries: int, words: Path, tmp_path: Path) -> None:
    out = tmp_path / "r.parquet"
    with loopback() as server:
        args = (words, "-m", f"openai:{rules}", "--base-url", server.address, "-o", out, "--retries", 3, "--limit", 6)
        evaluate(*args, code=0 if status == "answered" else 1)
        assert set(server.tries.values()) == {tries}
    got = rows(out)
    assert len(got) == 6
    assert {row["status"] for row in got} == {status}
    for row in got:
        assert row["parsed"] == (0 if status == "answered" else None)
        assert row["right"] == (status == "answered" and row["answer"] == 0)
        assert (row["error"] is not None) == (status == "error")
        assert row["model"] == f"openai:{rules}"
    about = json.loads(results.settings_path(out).read_text())
    assert about["replies"] == 6
    assert about["status"] == {status: 6}


@pytest.mark.parametrize("rules", slow_except(["right+chatty+429"], ["right", "right+chatty+429"]))
def test_system_that_knows_the_answers_is_right(rules: str, pictures: Path, tmp_path: Path) -> None:
    """Only what the request shows distinguishes it."""
    known = {(q.context[0], q.pictures[q.answer or 0]) for q in all_questions(pictures)}

    def right(parts: list[Any]) -> str:
        shown = [base64.b64decode(p["image_url"]["url"].split(",")[1]) for p in parts if p["type"] == "image_url"]
        return "ABCD"[next(i for i in range(4) if (shown[0], shown[-4 + i]) in known)]

    with loopback(right) as server:
        evaluate(
            pictures, "-m", f"openai:{rules}", "--base-url", server.address, "-o", tmp_path / "r.parquet", "--permute"
        )
    got = rows(tmp_path / "r.parquet")
    assert len(got) == 4 * len(all_questions(pictures))
    assert all(row["right"] for row in got)


def test_first_option_is_right_once_in_a_round(pictures: Path, tmp_path: Path) -> None:
    with loopback() as server:
        evaluate(
            pictures, "-m", "openai:first", "--base-url", server.address, "-o", tmp_path / "r.parquet", "--permute"
        )
    got = rows(tmp_path / "r.parquet")
    turns = Counter(row["id"] for row in got if row["right"])
    assert set(turns.values()) == {1}
    assert len(turns) == len(all_questions(pictures))
    for row in got:
        assert row["order"] == [(place + row["permutation"]) % 4 for place in range(4)]
        assert row["parsed"] == row["permutation"]


def test_answers_are_constrained_by_a_schema(words: Path, numbers: Path, tmp_path: Path) -> None:
    with loopback() as server:
        for name, dataset in (("words", words), ("numbers", numbers)):
            args = ("--base-url", server.address, "-o", tmp_path / f"{name}.parquet", "--structured")
            evaluate(dataset, "-m", "openai:structured", *args)
        forms = [body["response_format"]["json_schema"] for body in server.bodies]
    assert all(form["strict"] and form["schema"]["required"] == ["answer"] for form in forms)
    assert {json.dumps(form["schema"]["properties"]["answer"]) for form in forms} == {
        '{"type": "string", "enum": ["A", "B"]}',
        '{"type": "number"}',
    }
    assert {row["parsed"] for row in rows(tmp_path / "words.parquet") if row["order"][0] == 0} == {0}
    assert {row["number"] for row in rows(tmp_path / "numbers.parquet")} == {0.5}
    assert json.loads((tmp_path / "words.json").read_text())["asked"]["structured"]
    assert "only for -m openai" in evaluate(words, "-m", "random", "--structured", code=2).output


def test_a_wrong_key_stops_at_once_and_is_not_shown(words: Path, tmp_path: Path) -> None:
    with loopback() as server:
        args = ("-m", "openai:401", "--base-url", server.address, "-o", tmp_path / "r.parquet", "--concurrency", 2)
        done = evaluate(words, *args, code=2)
        assert len(server.bodies) <= 4
    assert "refuses `401`" in done.output
    assert SECRET not in done.output


def test_requests_to_a_dead_server_end(words: Path, tmp_path: Path) -> None:
    with loopback() as server:
        args = ("-m", "openai:down", "--base-url", server.address, "-o", tmp_path / "r.parquet", "--retries", 0)
        assert "20 requests in a row have failed" in evaluate(words, *args, code=2).output
        assert len(server.bodies) < len(all_questions(words)) + 8


def test_the_key_is_sent_and_written_nowhere(words: Path, tmp_path: Path) -> None:
    out = tmp_path / "r.parquet"
    with loopback() as server:
        common = ("--base-url", server.address, "-o", out, "--cache", tmp_path / "cache", "--limit", 3)
        done = evaluate(words, "-m", "openai:first+echo", *common)
        assert server.keys == {f"Bearer {SECRET}"}
    assert "[key]" in rows(out)[0]["text"]
    assert SECRET not in done.output
    assert all(SECRET.encode() not in path.read_bytes() for path in tmp_path.iterdir())
    assert all(SECRET not in json.dumps(row) for row in rows(out))


def test_replies_have_a_largest_size(words: Path, tmp_path: Path) -> None:
    out = tmp_path / "r.parquet"
    with loopback() as server:
        common = ("--base-url", server.address, "--retries", 0, "--limit", 1)
        evaluate(words, "-m", "openai:huge", *common, "-o", out, code=1)
        evaluate(words, "-m", "openai:long", *common, "-o", tmp_path / "long.parquet")
    assert "more than 4,194,304 bytes" in rows(out)[0]["error"]
    (long,) = rows(tmp_path / "long.parquet")
    assert len(long["text"]) == 65_536
    assert long["parsed"] == 1


def test_failed_requests_are_repeated_by_the_same_command(words: Path, tmp_path: Path) -> None:
    with loopback() as server:
        args = ("-m", "openai:first+429", "--base-url", server.address, "-o", tmp_path / "r.parquet", "--limit", 4)
        evaluate(words, *args, "--retries", 0, code=1)
        evaluate(words, *args, "--retries", 0, code=1)
        assert {row["status"] for row in rows(tmp_path / "r.parquet")} == {"error"}
        evaluate(words, *args, "--retries", 0)
        assert {row["status"] for row in rows(tmp_path / "r.parquet")} == {"answered"}
        evaluate(words, *args)
        assert set(server.tries.values()) == {3}


# ---------------------------------------------------------------- what is sent


def test_requests_are_the_same_again(words: Path, pictures: Path) -> None:
    for dataset in (words, pictures):
        twice_read = [all_questions(dataset)[::3] for _ in range(2)]
        for name in ("default", "paper", "numbers", "montage"):
            twice = [[Ask(q, prompt.load(name), 1).request.digest for q in few] for few in twice_read]
            assert twice[0] == twice[1]
            assert len(set(twice[0])) == len(twice[0])


@pytest.mark.parametrize(
    ("name", "text"),
    [
        (
            "default",
            "Picture 1: # Picture 2: # Where next? A. # B. # C. # D. #" + LETTER,
        ),
        (
            "numbers",
            "Picture 1: # Picture 2: # Where next? 1. # 2. # 3. # 4. #" + LETTER.replace("letter", "number"),
        ),
        ("paper", "# # # # # # Where next? The last 4 pictures are the options."),
        (
            "montage",
            "The sheet shows pictures 1 to 2 above and the options A, B, C, D below. # Where next?" + LETTER,
        ),
    ],
)
def test_prompt_text(name: str, text: str, pictures: Path) -> None:
    request = Ask(all_questions(pictures)[0], prompt.load(name)).request
    assert " ".join(part.text if isinstance(part, Text) else "#" for part in request.parts) == text


def test_options_are_turned_with_their_labels(pictures: Path, words: Path) -> None:
    one = all_questions(pictures)[0]
    shown = [part.content for part in Ask(one, prompt.load("default"), 1).request.parts if isinstance(part, Picture)]
    assert shown == [*one.context, *one.pictures[1:], one.pictures[0]]
    two = all_questions(words)[0]
    said = [part.text for part in Ask(two, prompt.load("default"), 1).request.parts if isinstance(part, Text)]
    assert f"A. {two.options[1]}\nB. {two.options[0]}" in said


def test_ablated_parts_are_absent(pictures: Path, words: Path) -> None:
    for name in prompt.builtin_prompts():
        for one in (all_questions(pictures)[0], all_questions(words)[0]):
            blind = Ask(one, prompt.load(name), ablation="pictures").request
            assert all(isinstance(part, Text) for part in blind.parts)
            assert Text(one.text) in blind.parts
            alone = Ask(one, prompt.load(name), ablation="question").request
            assert Text(one.text) not in alone.parts
            assert not any(isinstance(part, Picture) and part.content in one.context for part in alone.parts)


def test_a_montage_shows_all(pictures: Path) -> None:
    one = all_questions(pictures)[0]
    (sheet,) = [part for part in Ask(one, prompt.load("montage")).request.parts if isinstance(part, Picture)]
    seen = np.asarray(Image.open(io.BytesIO(sheet.content)).convert("RGB"))
    for png in (*one.context, *one.pictures):
        picture = np.asarray(Image.open(io.BytesIO(png)).convert("RGB"))
        height, width = picture.shape[:2]
        corners = (seen[: 1 - height, : 1 - width] == picture[0, 0]).all(axis=-1)
        assert any(np.array_equal(seen[y : y + height, x : x + width], picture) for y, x in np.argwhere(corners))


def test_a_clip_is_a_film(pictures: Path, tmp_path: Path) -> None:
    pytest.importorskip("imageio_ffmpeg")
    with loopback() as server:
        args = ("--base-url", server.address, "-o", tmp_path / "r.parquet", "--limit", 2, "--prompt", "clip")
        evaluate(pictures, "-m", "openai:first", *args)
        kinds = [part["type"] for part in server.bodies[0]["messages"][1]["content"]]
        film = next(p for p in server.bodies[0]["messages"][1]["content"] if p["type"] == "video_url")
    assert kinds.count("video_url") == 1
    assert kinds.count("image_url") == 4
    assert base64.b64decode(film["video_url"]["url"].split(",")[1])[4:8] == b"ftyp"


def test_a_prompt_of_ones_own(words: Path, tmp_path: Path) -> None:
    file = tmp_path / "mine.toml"
    file.write_text('extends = "paper"\nsystem = "Be brief."\n[texts]\nletters = "Which of {count}?"\n')
    with loopback() as server:
        args = ("--base-url", server.address, "-o", tmp_path / "r.parquet", "--limit", 1, "--prompt", file)
        evaluate(words, "-m", "openai:first", *args, "-p", "max_tokens=null", "-p", "effort=low")
        (body,) = server.bodies
    assert body["messages"][0]["content"] == "Be brief."
    assert body["messages"][1]["content"][-1]["text"] == "Which of 2?"
    assert (body["temperature"], body["effort"], "max_tokens" in body) == (0, "low", False)
    (row,) = rows(tmp_path / "r.parquet")
    assert (row["prompt"], row["prompt_hash"]) == ("mine", prompt.load(str(file)).hash)


@pytest.mark.parametrize(
    ("text", "reported"),
    [
        ('extends = "papr"', "there is no prompt"),
        ("x = ", "cannot be read"),
        ('extends = "default"\ncolour = "red"', "colour"),
        ('extends = "default"\n[texts]\npicture = "{nubmer}"', "did you mean `number`?"),
        ('extends = "default"\npictures = "film"', "pictures"),
        ('extends = "mine.toml"', "does not extend this one"),
    ],
)
def test_wrong_prompt_is_an_error(text: str, reported: str, words: Path, tmp_path: Path) -> None:
    (tmp_path / "mine.toml").write_text(text)
    assert (
        reported
        in evaluate(words, "-m", "oracle", "--prompt", tmp_path / "mine.toml", "-o", "r.parquet", code=2).output
    )


@pytest.mark.parametrize(
    ("args", "reported"),
    [
        (["-m", "oracle"], "add -o results.parquet"),
        (["-o", "r.parquet"], "missing DATASET or --model"),
        (["-m", "orcale", "-o", "r.parquet"], "did you mean `oracle`?"),
        (["-m", "openai:x", "--base-url", "http://me:pw@localhost/v1"], "without user, key"),
        (["-m", "openai:x", "--base-url", "localhost:80"], "expected an address"),
        (["-m", "openai:x", "--samples", "2"], "temperature"),
        (["-m", "blind", "-o", "r.parquet", "--ablate", "pictures"], "has no request to ablate"),
        (["-m", "openai:x", "-p", "max_tokens"], "expected NAME=VALUE"),
        (["-m", "oracle", "-o", "r.parquet", "--task", "rase"], "did you mean `race`?"),
        (["--rescore", "none.parquet"], "holds no results"),
        (["-m", "hf:nowhere", "-o", "r.parquet"], "hf:nowhere"),
    ],
)
def test_mistake_is_reported(
    args: list[str], reported: str, words: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    assert reported in evaluate(words, *args, code=2).output


def test_without_a_key_openai_gets_no_request(words: Path) -> None:
    args = ("-m", "openai:gpt", "-o", "r.parquet")
    assert "OPENAI_API_KEY" in evaluate(words, *args, code=2, OPENAI_API_KEY="", OPENAI_BASE_URL="").output


# ---------------------------------------------------------------- baselines


def test_baselines(words: Path, pictures: Path, numbers: Path, tmp_path: Path) -> None:
    for dataset in (words, pictures, numbers):
        for name in ("oracle", "random", "blind", "options-only"):
            out = tmp_path / f"{dataset.name}-{name}.parquet"
            evaluate(dataset, "-m", name, "-o", out, "--permute")
            first = out.read_bytes()
            assert {row["status"] for row in rows(out)} == {"answered"}
            if name == "oracle":
                assert all(row["right"] for row in rows(out))
            if dataset == pictures:
                out.unlink()
                evaluate(dataset, "-m", name, "-o", out, "--permute")
                assert out.read_bytes() == first


def test_a_baseline_finds_what_words_betray(tmp_path: Path) -> None:
    """Where "neither" is never true, who has read that knows; without anything to learn it guesses."""
    from tests.audit.made import make, race

    make(tmp_path / "telling", "race", race(telling=True), 80)
    evaluate(tmp_path / "telling", "-m", "options-only", "-o", tmp_path / "r.parquet")
    right = [row["right"] for row in rows(tmp_path / "r.parquet")]
    assert sum(right) > 0.9 * len(right)


def test_numbers_are_right_within(numbers: Path, tmp_path: Path) -> None:
    with loopback(lambda parts: "About 55 cm.") as server:
        evaluate(numbers, "-m", "openai:right", "--base-url", server.address, "-o", tmp_path / "r.parquet", "--permute")
        assert server.bodies[0]["messages"][1]["content"][-1]["text"].endswith("Answer with a number in m alone.")
    for row in rows(tmp_path / "r.parquet"):
        assert row["number"] == pytest.approx(0.55)
        assert row["right"] == (abs(row["answer_number"] - 0.55) <= 0.02 + 1e-9)
        assert (row["answer"], row["parsed"], row["options"]) == (None, None, [])


# ---------------------------------------------------------------- limits, cache, resuming


def test_limits_hold_and_the_same_command_goes_on(words: Path, tmp_path: Path) -> None:
    out = tmp_path / "r.parquet"
    with loopback() as server:
        args = ("-m", "openai:first", "--base-url", server.address, "-o", out)
        assert "17 requests were not sent" in evaluate(words, *args, "--max-requests", 7).output
        assert len(server.bodies) == 7
        # A reply is 1,000 tokens in and 10 out: at these prices .00102.
        evaluate(words, *args, "--max-cost", 0.0051, "--price", 1, 2)
        assert len(server.bodies) == 12
        evaluate(words, *args, "--max-cost", 0.0051, "--price", 1, 2)
        assert len(server.bodies) == 12
        evaluate(words, *args)
        assert len(server.bodies) == 24
        assert set(server.tries.values()) == {1}
    assert len(rows(out)) == 24


def test_cost_limit_needs_prices(words: Path, tmp_path: Path) -> None:
    with loopback() as server:
        args = ("-m", "openai:first", "--base-url", server.address, "-o", tmp_path / "r.parquet", "--max-cost", 1)
        assert "add --price" in evaluate(words, *args, code=2).output
        assert len(server.bodies) == 1


def test_a_limit_is_even_over_tasks_and_engines(words: Path, tmp_path: Path) -> None:
    evaluate(words, "-m", "random", "-o", tmp_path / "r.parquet", "--limit", 6)
    assert Counter(row["engine"] for row in rows(tmp_path / "r.parquet")) == {"mujoco": 3, "pybullet": 3}
    assert len({row["index"] for row in rows(tmp_path / "r.parquet")}) == 3, "the same in both engines"
    few = {row["id"] for row in rows(tmp_path / "r.parquet")}
    evaluate(words, "-m", "random", "-o", tmp_path / "r.parquet", "--limit", 10)
    more = {row["id"] for row in rows(tmp_path / "r.parquet")}
    assert few < more
    assert len(more) == 10
    evaluate(words, "-m", "random", "-o", tmp_path / "e.parquet", "--engine", "pybullet")
    assert Counter(row["engine"] for row in rows(tmp_path / "e.parquet")) == {"pybullet": 12}


def test_the_same_request_is_not_paid_twice(words: Path, tmp_path: Path) -> None:
    with loopback() as server:
        args = ("--base-url", server.address, "--cache", tmp_path / "cache", "--price", 1, 2)
        evaluate(words, "-m", "openai:first", *args, "-o", tmp_path / "1.parquet")
        evaluate(words, "-m", "openai:first", *args, "-o", tmp_path / "2.parquet", "--permute")
        assert set(server.tries.values()) == {1}
        assert len(server.bodies) == 2 * 24
        evaluate(words, "-m", "openai:first+lower", *args, "-o", tmp_path / "3.parquet")
        assert len(server.bodies) == 3 * 24
        warm = ("-p", "temperature=1", "--samples", 3, "--limit", 2)
        evaluate(words, "-m", "openai:first", *args, "-o", tmp_path / "4.parquet", *warm)
        assert len(server.bodies) == 3 * 24 + 6
    assert {row["cost"] for row in rows(tmp_path / "2.parquet") if row["permutation"] == 0} == {0.0}


def test_other_settings_do_not_mix(words: Path, tmp_path: Path) -> None:
    out = tmp_path / "r.parquet"
    evaluate(words, "-m", "random", "-o", out)
    assert "model differ" in evaluate(words, "-m", "oracle", "-o", out, code=2).output
    assert (
        "prompt, prompt_hash differ" in evaluate(words, "-m", "random", "-o", out, "--prompt", "paper", code=2).output
    )


def test_files_of_others_stay(words: Path, tmp_path: Path) -> None:
    mine = {"r.json": '{"mine": 1}', "s.journal.jsonl": '{"mine": 1}\n', "t.parquet": "mine"}
    for name, content in mine.items():
        (tmp_path / name).write_text(content)
        out = tmp_path / f"{name[0]}.parquet"
        assert str(tmp_path / name) in evaluate(words, "-m", "oracle", "-o", out, code=2).output
        assert (tmp_path / name).read_text() == content
    line: dict[str, dict[str, Any]] = {"asked": {}}
    (tmp_path / "u").write_text(json.dumps(line) + '\n{"id": "a", "colour": "red"}\n')
    with pytest.raises(WmsError, match="no journal of this version"):
        Journal(tmp_path / "u", {})


def _start(words: Path, address: str, out: Path) -> subprocess.Popen[bytes]:
    args = [
        "evaluate",
        str(words),
        "-m",
        "openai:first+slow",
        "--base-url",
        address,
        "-o",
        str(out),
        "--concurrency",
        "3",
    ]
    return subprocess.Popen(
        [sys.executable, "-m", "wmspec", *args],
        stderr=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        env=os.environ.copy(),
    )


@pytest.mark.slow
def test_killed_at_any_moment_no_reply_is_lost_or_doubled(words: Path, tmp_path: Path) -> None:
    out, draw = tmp_path / "r.parquet", random.Random(4)
    journal = out.with_suffix(".journal.jsonl")
    kills = 0
    with loopback() as server:
        while not out.exists():
            run = _start(words, server.address, out)
            enough = len(server.bodies) + draw.randint(2, 12)
            while run.poll() is None and len(server.bodies) < enough:
                time.sleep(0.01)
            kills += run.poll() is None
            run.kill()
            run.wait()
        assert kills > 1
        assert len(server.bodies) <= 24 + 3 * kills, "what was answered was asked again"
    keys = [(row["id"], row["permutation"], row["sample"]) for row in rows(out)]
    assert sorted(id for id, _, _ in keys) == sorted(q.id for q in all_questions(words, pictures=False))
    assert len(set(keys)) == len(keys)
    assert not journal.exists()


@settings(max_examples=30)
@given(st.integers(0, 400), st.binary(max_size=3))
def test_truncated_line_is_removed(cut: int, rest: bytes) -> None:
    import tempfile

    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "j"
        with Journal(path, {"model": "m"}) as journal:
            for number in range(4):
                journal.keep((f"t/{number}/q0/e", 0, 0), Reply(f"text {number} \ud800"[:7]))
        whole = path.read_bytes()
        head = whole.index(b"\n") + 1
        cut = min(head + cut, len(whole))
        path.write_bytes(whole[:cut] + rest.replace(b"\n", b""))
        with Journal(path, {"model": "m"}) as journal:
            left = whole[head:cut].count(b"\n")
            assert [reply.text for reply in journal.replies.values()] == [f"text {n} "[:7] for n in range(left)]
            journal.keep(("t/9/q0/e", 0, 0), Reply("again"))
        with Journal(path, {"model": "m"}) as journal:
            assert len(journal.replies) == left + 1


def test_two_do_not_write_to_one_result(words: Path, tmp_path: Path) -> None:
    with Journal(tmp_path / "r.journal.jsonl", {}):
        assert "another process" in evaluate(words, "-m", "oracle", "-o", tmp_path / "r.parquet", code=2).output


# ---------------------------------------------------------------- results


def test_results_are_scored_again_from_their_texts(words: Path, tmp_path: Path) -> None:
    out = tmp_path / "r.parquet"
    with loopback() as server:
        evaluate(words, "-m", "openai:first+chatty", "--base-url", server.address, "-o", out, "--permute")
    before = rows(out)
    table, about = results.read(out)
    results.write(out, [{**row, "parsed": None, "right": False, "status": "unparsed"} for row in table], about)
    assert "scores have changed" in evaluate("--rescore", out).output
    assert rows(out) == before


def test_the_columns_of_results(words: Path, tmp_path: Path) -> None:
    """What reports and other programs rely on."""
    evaluate(words, "-m", "oracle", "-o", tmp_path / "r.parquet", "--limit", 1)
    (row,) = rows(tmp_path / "r.parquet")
    first = next(q for q in all_questions(words) if q.id == row["id"])
    assert row["group"] == f"race/{first.block}" == first.group
    assert row["options"] == list(first.options)
    assert {"seconds", "cost", "tokens_in", "tokens_out", "model_version", "sample", "order"} <= row.keys()
    about = json.loads((tmp_path / "r.json").read_text())
    assert about["asked"]["model"] == "oracle"
    assert about["template"]["labels"] == {"words": "letters", "pictures": "letters"}


def test_a_dry_run_asks_nothing(pictures: Path) -> None:
    with loopback() as server:
        done = evaluate(pictures, "-m", "openai:first", "--base-url", server.address, "--dry-run", "--permute")
        assert not server.bodies
    assert "96 requests for 24 questions" in done.output
    assert "Where next?" in done.output


def test_counts_as_json(words: Path, tmp_path: Path) -> None:
    done = CliRunner().invoke(
        main, ["evaluate", str(words), "-m", "oracle", "-o", str(tmp_path / "r.parquet"), "--json"]
    )
    assert json.loads(done.stdout)["right"] == 24
