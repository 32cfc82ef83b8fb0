"""A wall clock that jumps by days, forwards and backwards, loses nothing and changes no measured time."""

from __future__ import annotations

import http.client
import json
import sqlite3
import subprocess
import sys
import time
from contextlib import closing
from pathlib import Path

import pyarrow.parquet as pq
import pytest

from tests.dataset.made import make as make_dataset
from tests.dataset.made import plan
from tests.evaluate.loopback import loopback
from tests.evaluate.made import in_words
from tests.study.visitor import Process, letter, post
from tests.trust.shifted_clock import DAY, jumping_everywhere, jumping_in_python
from wmspec.dataset.build.reader import DatasetReader
from wmspec.eval.study import store
from wmspec.eval.study.make import StudyOptions, make
from wmspec.eval.study.model import load
from wmspec.eval.study.store import AnswerStore

#: Looks of the server at its connections are half a second apart.
LOOKS = 1.2


@pytest.fixture(params=["Python", "process"])
def jumping(request: pytest.FixtureRequest, tmp_path: Path) -> dict[str, str]:
    if request.param == "Python":
        return jumping_in_python(tmp_path / "clock")
    environment = jumping_everywhere(tmp_path / "clock")
    if environment is None or sys.platform != "linux":
        pytest.skip("there is no C compiler, or the functions of this C library cannot be replaced")
    return environment


def slowly(port: int, path: str, body: dict[str, object]) -> int:
    """Send half of a request, wait for looks of the server, and send the rest; the status."""
    content = json.dumps(body).encode()
    connection = http.client.HTTPConnection("127.0.0.1", port, timeout=60)
    with closing(connection):
        connection.putrequest("POST", path)
        connection.putheader("Content-Type", "application/json")
        connection.putheader("Content-Length", str(len(content)))
        connection.endheaders(content[:5])
        time.sleep(LOOKS)
        connection.send(content[5:])
        return connection.getresponse().status


@pytest.mark.slow
def test_a_study_is_served_while_the_clock_jumps(tmp_path: Path, jumping: dict[str, str]) -> None:
    """Two people answer, with other times, retries and a slow connection; the server is killed and started again."""
    make_dataset(tmp_path / "dataset", plan(count=2), size=24)
    folder = tmp_path / "study"
    make(DatasetReader.open(tmp_path / "dataset"), StudyOptions(per_task=2, raters=2, check_every=3), folder)
    study, server = load(folder), Process(folder, jumping)
    sent: dict[str, list[tuple[int, str, float, float]]] = {}
    try:
        for visitor in range(2):
            session = f"{visitor:032x}"
            status, place = post(server.port, "/visits", {"session": session, "rater": f"r{visitor}"})
            assert status == 200
            for step in range(len(study.slots[place["slot"]])):
                text, seconds = letter(study, place["slot"], step), 0.25 + step
                body = {"step": step, "text": text, "seconds": seconds, "away": 0.125}
                path = f"/visits/{session}/answers"
                assert step != 1 or slowly(server.port, path, body) == 200
                if step == 2:
                    server.kill()
                    server.begin()
                assert post(server.port, path, body)[0] == 200
                assert post(server.port, path, {**body, "seconds": 9.0})[0] == 200  # the first one counts
                sent.setdefault(session, []).append((step, text, seconds, 0.125))
    finally:
        server.kill()
    answers = AnswerStore(folder / store.ANSWERS_FILE, study)
    kept = {v.session: [(a.step, a.text, a.seconds, a.away) for a in v.answers] for v in answers.visits()}
    answers.close()
    assert kept == sent
    if "LD_PRELOAD" in jumping:
        with closing(sqlite3.connect(folder / store.ANSWERS_FILE)) as file:
            ((first, last),) = file.execute("select min(unixepoch(at)), max(unixepoch(at)) from answer")
        assert last - first > DAY, "the clock of the server did not jump"
    command = [sys.executable, "-m", "wmspec", "study", "collect", folder, "-o", tmp_path / "r.parquet"]
    subprocess.run(list(map(str, command)), env=jumping, check=True, timeout=300)
    collected = pq.read_table(tmp_path / "r.parquet")["seconds"].to_pylist()
    assert collected
    assert all(0.25 <= seconds < 100 for seconds in collected)


@pytest.mark.slow
def test_the_seconds_of_replies_while_the_clock_jumps(tmp_path: Path, jumping: dict[str, str]) -> None:
    """Replies take the time that they take, also those that come at the third try."""
    dataset, out = in_words(tmp_path / "dataset"), tmp_path / "r.parquet"
    with loopback() as server:
        command = [sys.executable, "-m", "wmspec", "evaluate", dataset, "-m", "openai:first+429", "-o", out]
        began = time.monotonic()
        subprocess.run([*map(str, command), "--base-url", server.address], env=jumping, check=True, timeout=300)
        longest = time.monotonic() - began
    seconds = pq.read_table(out)["seconds"].to_pylist()
    assert seconds
    assert all(0 <= each <= longest for each in seconds)
