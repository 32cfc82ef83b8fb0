"""From questions without answers to a leaderboard: nothing leaks, every reply counts, and no receipt can be forged."""

from __future__ import annotations

import io
import json
import os
import re
import runpy
import subprocess
import sys
from collections import Counter
from collections.abc import Iterator
from contextlib import redirect_stderr, redirect_stdout
from dataclasses import dataclass
from itertools import cycle
from pathlib import Path
from typing import Any

import pyarrow.parquet as pq
import pytest
from click.testing import CliRunner, Result

from tests.browser import barriers, opened
from tests.evaluate.made import in_numbers, in_pictures, in_words
from tests.evaluate.manners import MANNERS, Manner, Response, chat, error, first_words, server
from wmspec.cli import main
from wmspec.dataset.build.reader import DatasetReader
from wmspec.eval.models.question import Question, questions
from wmspec.eval.publish.secret import Secret
from wmspec.eval.replies import LETTERS

pytest.importorskip("pandas")


def wmspec(*args: object, code: int = 0) -> Result:
    done = CliRunner().invoke(main, [str(arg) for arg in args])
    assert done.exit_code == code, done.output
    return done


def question_list(dataset: Path) -> list[Question]:
    opened = DatasetReader.open(dataset)
    ids = [row["id"] for task in opened.tasks for row in opened.rows(task, ["id"])]
    return list(questions(opened, ids, pictures=False))


class Holder:
    """Who holds the answers: a dataset, a secret, and the folder that was published."""

    def __init__(self, folder: Path, dataset: Path) -> None:
        self.folder, self.dataset = folder, dataset
        self.secret, self.public = folder / "secret.key", folder / "public"
        wmspec("export", dataset, "--to", "questions", "-o", self.public, "--secret", self.secret)
        self.index: dict[str, Any] = json.loads((self.public / "questions.json").read_text())

    def submission(self, name: str, right: float = 1.0, **changed: str) -> Path:
        """A file in which the first share of the questions is answered rightly."""
        key = Secret.read(self.secret)
        lines: list[dict[str, Any]] = [{"questions": self.index["digest"], "model": name} | changed]
        known = question_list(self.dataset)
        for number, q in enumerate(known):
            true = LETTERS[q.answer] if q.answer is not None else f"{q.number} {q.unit}"
            false = LETTERS[((q.answer or 0) + 1) % max(1, len(q.options))] if q.options else "none"
            reply = true if number < right * len(known) else false
            lines.append({"id": key.public_id(q.task, q.id), "reply": reply, "finish_reason": "stop"})
        path = self.folder / f"{name}.jsonl"
        path.write_text("".join(json.dumps(line) + "\n" for line in lines))
        return path

    def score(self, submission: Path, code: int = 0) -> Path:
        path = self.folder / "receipts" / f"{submission.stem}.json"
        args = (self.dataset, self.public, submission, "--secret", self.secret, "-o", path, "--date", "2026-11-26")
        wmspec("score", *args, code=code)
        return path


@dataclass(frozen=True)
class Answered:
    """How the script of the folder ended, and what it said."""

    code: int
    said: str


def answer(holder: Holder, *args: object, key: str = "none") -> Answered:
    """Run the script of the folder in this process, as `python answer.py` would in another."""
    script, said = str(holder.public / "answer.py"), io.StringIO()
    with pytest.MonkeyPatch.context() as patch, redirect_stdout(said), redirect_stderr(said):
        patch.setenv("OPENAI_API_KEY", key)
        patch.setattr(sys, "argv", [script, *map(str, args)])
        patch.syspath_prepend(str(holder.public))
        try:
            runpy.run_path(script, run_name="__main__")
        except SystemExit as end:
            return Answered(1, f"{said.getvalue()}{end.code}\n")
        finally:
            sys.modules.pop("wmspec_reply", None)
    return Answered(0, said.getvalue())


@pytest.fixture(scope="module")
def holder(tmp_path_factory: pytest.TempPathFactory) -> Holder:
    folder = tmp_path_factory.mktemp("holder")
    return Holder(folder, in_words(folder / "d"))


def test_published_questions_hold_no_answer_and_no_id(holder: Holder) -> None:
    known = question_list(holder.dataset)
    (table,) = [pq.read_table(path) for path in (holder.public / "data").iterdir()]
    assert not {name for name in table.column_names if "answer" in name or name in ("group", "engine", "index")}
    public = table["id"].to_pylist()
    assert public == sorted(public), "the order follows from nothing but the hidden ids"
    assert len(set(public)) == len(known)
    written = b"".join(path.read_bytes() for path in holder.public.rglob("*") if path.is_file())
    for q in known:
        assert q.id.partition("/")[2].encode() not in written
    assert holder.secret.stat().st_mode & 0o077 == 0
    assert holder.secret.read_text().split()[1].encode() not in written


def test_a_short_seed_is_a_warning(holder: Holder, tmp_path: Path) -> None:
    args = ("export", holder.dataset, "--to", "questions", "-o", tmp_path / "q", "--secret", tmp_path / "s.key")
    assert "the seed 3 can be found by trying" in wmspec(*args).output


def test_the_position_of_an_option_does_not_follow_from_the_id(holder: Holder) -> None:
    other = Holder(holder.folder / "other", holder.dataset) if not (holder.folder / "other").exists() else None
    assert other is not None
    assert other.index["digest"] != holder.index["digest"], "another secret, other ids"


@pytest.mark.parametrize("make", [in_words, in_pictures, in_numbers])
def test_scores_are_exact(make: Any, tmp_path: Path) -> None:
    holder = Holder(tmp_path, make(tmp_path / "d"))
    for name, share in (("all", 1.0), ("half", 0.5), ("none", 0.0)):
        wmspec("submit", holder.public, holder.submission(name, share))
        receipt = json.loads(holder.score(tmp_path / f"{name}.jsonl").read_text())
        (scores,) = receipt["scores"].values()
        assert scores["average"]["value"] == pytest.approx(share)
        assert sum(receipt["outcomes"].values()) == receipt["count"] == len(question_list(holder.dataset))
        assert (receipt["model"], receipt["date"]) == (name, "2026-11-26")


def test_private_results_are_those_of_evaluate(holder: Holder, tmp_path: Path) -> None:
    """They are for equating and reports; nobody else has them."""
    submission, out = holder.submission("half", 0.5), tmp_path / "half.parquet"
    args = (holder.dataset, holder.public, submission, "--secret", holder.secret, "-o", tmp_path / "r.json")
    wmspec("score", *args, "--results", out)
    table = pq.read_table(out).to_pandas()
    assert set(table["id"]) == {q.id for q in question_list(holder.dataset)}
    assert table["right"].mean() == pytest.approx(0.5)
    wmspec("report", out, "--dataset", holder.dataset, "-o", tmp_path / "report")


def test_missing_and_failed_replies_are_wrong(holder: Holder) -> None:
    path = holder.submission("partial")
    about, *lines = path.read_text().splitlines()
    changed = [json.loads(line) for line in lines[:-4]]
    changed[0] |= {"reply": "A, B"}
    changed[1] |= {"reply": "", "error": "broken"}
    changed[2] |= {"reply": "The answer might", "finish_reason": "length"}
    changed[3] |= {"finish_reason": "content_filter"}
    path.write_text("\n".join([about, *map(json.dumps, changed)]))
    output = wmspec("submit", holder.public, path, code=1).output
    assert "4 questions have no reply" in output
    receipt = json.loads(holder.score(path).read_text())
    assert receipt["outcomes"] == {"answered": 16, "error": 5, "refused": 1, "truncated": 1, "unparsed": 1}
    (scores,) = receipt["scores"].values()
    assert scores["average"]["value"] == pytest.approx(16 / 24)
    assert scores["answered"] == 1.0


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda lines: lines[1:], "not a line of a submission"),
        (lambda lines: [lines[0].replace('"model"', '"modle"'), *lines[1:]], "not a line of a submission"),
        (lambda lines: [*lines, lines[-1]], "a second reply"),
        (lambda lines: [*lines, '{"id": "race/0000", "reply": "A"}'], "there is no question"),
        (lambda lines: [*lines, "{"], "not a line of a submission"),
        (lambda lines: [*lines, "[" * 100_000], "not a line of a submission"),
        (lambda lines: ['{"questions": "' + "0" * 64 + '", "model": "m"}', *lines[1:]], "it answers other questions"),
        (lambda lines: [], "the file is empty"),
    ],
)
def test_a_wrong_submission_is_an_error_with_its_line(
    change: Any, message: str, holder: Holder, tmp_path: Path
) -> None:
    lines = change(holder.submission("wrong").read_text().splitlines())
    (tmp_path / "s.jsonl").write_text("\n".join(lines))
    assert message in wmspec("submit", holder.public, tmp_path / "s.jsonl", code=2).output
    args = ("--secret", holder.secret, "-o", tmp_path / "r.json")
    assert message in wmspec("score", holder.dataset, holder.public, tmp_path / "s.jsonl", *args, code=2).output
    assert not (tmp_path / "r.json").exists()


def test_a_forged_or_edited_receipt_is_refused(holder: Holder, tmp_path: Path) -> None:
    receipts = tmp_path / "receipts"
    receipts.mkdir()
    right = json.loads(holder.score(holder.submission("honest", 0.5)).read_text())
    (receipts / "honest.json").write_text(json.dumps(right))
    wmspec("leaderboard", receipts, "--secret", holder.secret, "-o", tmp_path / "site")
    kind = next(iter(right["scores"]))
    better = json.loads(json.dumps(right))
    better["scores"][kind]["average"]["value"] = 1.0
    edits = (
        better,
        right | {"model": "somebody else"},
        right | {"outcomes": {"answered": 23, "error": 1}},
        right | {"date": "2027-01-01"},
        right | {"signature": "0" * 64},
        right | {"signature": None},
        right | {"signature": "é" * 64},
        right | {"notes": json.loads("[" * 900 + "]" * 900)},
        right | {"extra": 1},
        {name: value for name, value in right.items() if name != "notes"},
        right | {"scores": {kind: {"average": float("nan")}}},
    )
    for edited in edits:
        (receipts / "edited.json").write_text(json.dumps(edited))
        output = wmspec("leaderboard", receipts, "--secret", holder.secret, "-o", tmp_path / "no", code=2).output
        assert "forged, or was edited" in output
        assert "edited.json" in output
    Secret.open_or_create(tmp_path / "another.key")
    (receipts / "edited.json").unlink()
    args = ("--secret", tmp_path / "another.key", "-o", tmp_path / "no")
    assert "forged" in wmspec("leaderboard", receipts, *args, code=2).output
    assert not (tmp_path / "no").exists()


def test_other_files_of_a_signed_receipt_are_harmless(holder: Holder, tmp_path: Path) -> None:
    """The page holds what was signed, once, whatever else a file says or how it is written."""
    receipts = tmp_path / "receipts"
    receipts.mkdir()
    text = holder.score(holder.submission("perfect")).read_text()
    signed = json.loads(text)
    (receipts / "a.json").write_text(text.replace('"model": ', '"model": "somebody else", "model": ', 1))
    (receipts / "b.json").write_text(json.dumps(signed, sort_keys=True, separators=(",", ":")))
    wmspec("leaderboard", receipts, "--secret", holder.secret, "-o", tmp_path / "site")
    assert [path.name for path in (tmp_path / "site/receipts").iterdir()] == ["a.json"]
    assert "somebody else" not in (tmp_path / "site/receipts/a.json").read_text()
    assert json.loads((tmp_path / "site/receipts/a.json").read_text()) == signed
    (scores,) = signed["scores"].values()
    assert type(scores["average"]["value"]) is int, "JavaScript writes 1.0 as 1, which has another signature"


def test_a_withdrawn_receipt_is_no_longer_published(holder: Holder, tmp_path: Path) -> None:
    receipts, site = tmp_path / "receipts", tmp_path / "site"
    receipts.mkdir()
    for name in ("stays", "goes"):
        (receipts / f"{name}.json").write_bytes(holder.score(holder.submission(name)).read_bytes())
    wmspec("leaderboard", receipts, "--secret", holder.secret, "-o", site)
    (site / "receipts/mine.json").write_text("{}")
    (receipts / "goes.json").unlink()
    wmspec("leaderboard", receipts, "--secret", holder.secret, "-o", site)
    assert sorted(path.name for path in (site / "receipts").iterdir()) == ["mine.json", "stays.json"]
    (site / "receipts/mine.json").unlink()
    (site / "receipts/copy.json").write_bytes((receipts / "stays.json").read_bytes())
    wmspec("leaderboard", site / "receipts", "--secret", holder.secret, "-o", site)
    assert sorted(path.name for path in (site / "receipts").iterdir()) == ["copy.json", "stays.json"], "inputs stay"


@pytest.mark.parametrize("change", ["separators", "mark", "lines"])
def test_a_submission_may_come_from_any_writer_of_json(change: str, holder: Holder, tmp_path: Path) -> None:
    about, *lines = map(json.loads, holder.submission("any").read_text().splitlines())
    lines[0]["reply"] += "\u2028\x85"
    text = "\n".join(json.dumps(line, ensure_ascii=False) for line in (about, *lines))
    text = {"separators": text, "mark": "\ufeff" + text, "lines": text.replace("\n", "\r\n") + "\r\n"}[change]
    (tmp_path / "s.jsonl").write_bytes(text.encode())
    assert "24 of 24 replies" in wmspec("submit", holder.public, tmp_path / "s.jsonl").output


def test_the_script_of_the_folder_has_the_outcomes_of_evaluate(
    holder: Holder, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip("openai")
    out, outcomes = tmp_path / "submission.jsonl", Counter[str]()
    manners = cycle(MANNERS[name] for name in ("parts", "refusal field", "filter status", "moderation", "cut"))

    def respond(*request: Any) -> Response:
        manner = next(manners)
        outcomes[manner.outcome] += 1
        return manner.respond(*request)

    monkeypatch.setitem(MANNERS, "in turn", Manner(respond))
    with server(first_words) as running:
        command = [sys.executable, str(holder.public / "answer.py"), "--model", "in_turn"]
        command += ["--output", str(out), "--base-url", running.address]
        subprocess.run(command, check=True, env={"OPENAI_API_KEY": "none", "PATH": os.environ["PATH"]})
    said = wmspec("submit", holder.public, out).output
    assert outcomes == {"answered": 5, "refused": 15, "truncated": 4}, "one request for each question"
    assert all(re.search(rf"\b{count} {outcome}\b", said) for outcome, count in outcomes.items()), said


def test_the_script_of_the_folder_answers_a_server_and_resumes(holder: Holder, tmp_path: Path) -> None:
    pytest.importorskip("openai")
    out = tmp_path / "submission.jsonl"
    with server(first_words) as running:
        args = ("--model", "chatty", "--output", out, "--base-url", running.address, "--name", "Chatty")
        assert answer(holder, *args) == Answered(0, "")
        whole = out.read_text()
        out.write_text("".join(whole.splitlines(keepends=True)[:10]) + '{"id": "race/')
        sent = sum(running.tries.values())
        assert answer(holder, *args).code == 0
        assert sum(running.tries.values()) == sent + 24 - 9
    assert out.read_text() == whole
    assert "Chatty, prompt default: 24 of 24 replies\n24 answered" in wmspec("submit", holder.public, out).output


def test_the_script_of_the_folder_sends_failed_requests_again(
    holder: Holder, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip("openai")
    out, broken = tmp_path / "submission.jsonl", [5]

    def respond(label: str, *_: object) -> Response:
        broken[0] -= 1
        return (200, b"<html>") if broken[0] >= 0 else chat(label)

    monkeypatch.setitem(MANNERS, "html", Manner(respond))
    with server(first_words) as running:
        args = ("--model", "html", "--output", out, "--base-url", running.address)
        assert answer(holder, *args) == Answered(1, "5 requests have failed; the same command sends them again\n")
        assert "19 answered, 5 error" in wmspec("submit", holder.public, out).output
        assert answer(holder, *args).code == 0
        assert "24 answered" in wmspec("submit", holder.public, out).output
        broken[0], whole = 99, out.read_text()
        out.unlink()
        stopped = answer(holder, *args)
        assert stopped.said.startswith("20 requests in a row have failed; the last: ")
    ids = [json.loads(line).get("id") for line in whole.splitlines()]
    assert len(set(ids)) == len(ids) == 25


def test_the_script_of_the_folder_writes_no_key(
    holder: Holder, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip("openai")
    responses = cycle((chat("A sk-0123456789"), chat("A", "sk-0123456789"), error(400, "sk-0123456789")))
    monkeypatch.setitem(MANNERS, "echo", Manner(lambda *_: next(responses)))
    out = tmp_path / "submission.jsonl"
    with server(first_words) as running:
        args = ("--model", "echo", "--output", out, "--base-url", running.address)
        done = answer(holder, *args, key="sk-0123456789")
    _, *lines = out.read_text().splitlines()
    assert len(lines) == 24
    assert all("[key]" in line for line in lines)
    assert "sk-0123456789" not in out.read_text() + done.said


@pytest.fixture
def page(browser: Any, holder: Holder, tmp_path: Path) -> Iterator[Any]:
    for name, share in (("worst", 0.25), ("best <b>", 0.875), ("middle", 0.5)):
        path = holder.submission(name.split()[0], share, model=name)
        receipt = holder.score(path)
        (tmp_path / "receipts").mkdir(exist_ok=True)
        (tmp_path / "receipts" / receipt.name).write_bytes(receipt.read_bytes())
    args = (tmp_path / "receipts", "--secret", holder.secret, "-o", tmp_path / "site", "--title", "Race")
    wmspec("leaderboard", *args)
    yield from opened(browser, tmp_path / "site/index.html")


@pytest.mark.browser
def test_the_page_is_sorted_by_its_headings(page: Any) -> None:
    def names() -> list[str]:
        found: list[str] = page.eval_on_selector_all("tbody th", "all => all.map(c => c.innerText)")
        return found

    assert names() == ["best <b>", "middle", "worst"]
    page.click("thead th:nth-child(2) button")
    page.click("thead th:nth-child(2) button")
    assert names() == ["worst", "middle", "best <b>"]
    assert page.get_attribute("thead th:nth-child(2)", "aria-sort") == "ascending"
    page.click("thead th:nth-child(1) button")
    assert names() == ["best <b>", "middle", "worst"]
    assert page.locator("tbody tr:first-child td.number small").first.inner_text().count("–") == 1
    assert barriers(page) == []
