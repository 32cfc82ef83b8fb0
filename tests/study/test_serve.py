"""The server: an answer is kept once and for good, whatever happens to it; and it does nothing but that."""

from __future__ import annotations

import http.client
import random
import socket
import threading
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.study.visitor import Process, get, letter, post
from wmspec.core.diagnostics import WmsError
from wmspec.dataset.build.reader import DatasetReader
from wmspec.eval.study import store
from wmspec.eval.study.answers import Answer, Person
from wmspec.eval.study.collect import collect
from wmspec.eval.study.make import StudyOptions, make
from wmspec.eval.study.model import load
from wmspec.eval.study.serve import MAX_REQUEST_BYTES, StudyServer
from wmspec.eval.study.store import AnswerStore, StudyFull

ANNE = "a" * 32


@pytest.fixture
def port(study: Path) -> Iterator[int]:
    with StudyServer(study, "127.0.0.1", 0) as server:
        thread = threading.Thread(target=server.serve_forever)
        thread.start()
        yield server.server_address[1]
        server.shutdown()
        thread.join()


# ---------------------------------------------------------------- what is kept


@pytest.mark.slow
@pytest.mark.parametrize("seed", [1, 2])
def test_killed_at_any_moment_no_answer_is_lost_or_doubled(seed: int, study: Path) -> None:
    """A visitor answers and tries again whatever is not heard, while the server is killed by chance over and over."""
    made, server, chance = load(study), Process(study), random.Random(seed)
    over, kills, heard = threading.Event(), 0, []

    def killing() -> None:
        nonlocal kills
        while not over.wait(chance.uniform(0.0, 0.15)):
            server.kill()
            kills += 1
            server.begin()

    def said(path: str, body: dict[str, object]) -> dict[str, object]:
        while True:
            try:
                status, value = post(server.port, path, body)
            except (OSError, http.client.HTTPException):
                over.wait(0.01)
                continue
            assert status == 200, value
            return dict(value)

    killer = threading.Thread(target=killing)
    killer.start()
    try:
        for visitor in range(3):
            session = f"{visitor:032x}"
            place = said("/visits", {"session": session, "rater": f"r{visitor}"})
            slot = int(str(place["slot"]))
            for step in range(len(made.slots[slot])):
                answer = {"step": step, "text": letter(made, slot, step), "seconds": 1.5 + step}
                place = said(f"/visits/{session}/answers", answer)
                heard.append((session, step))
                assert place["done"] == list(range(step + 1))
            assert place["code"]
    finally:
        over.set()
        killer.join()
        server.kill()
    assert kills > 0
    kept = [(v.session, a.step) for v in AnswerStore(study / store.ANSWERS_FILE, made).visits() for a in v.answers]
    assert kept == heard
    collected = collect(study, (), study / "results.parquet")
    assert collected.missing == 0
    assert collected.replies == 36
    assert all(rater.right == rater.questions and rater.checks_passed == rater.checks for rater in collected.raters)


def test_the_first_answer_to_a_step_stands(study: Path) -> None:
    opened = AnswerStore(study / store.ANSWERS_FILE, load(study))
    assert opened.keep(ANNE, Answer(step=0, text="A", seconds=1)) is None, "nobody has begun"
    opened.begin(Person(session=ANNE))
    for text in "AB":
        place = opened.keep(ANNE, Answer(step=0, text=text, seconds=1))
        assert place
        assert place.done == (0,)
    assert opened.keep(ANNE, Answer(step=999, text="A", seconds=1)) is None
    assert opened.keep(ANNE, Answer(step=1, text="Z", seconds=1)) is None
    assert opened.keep(ANNE, Answer(step=1, text="7", seconds=1)) is None
    opened.close()
    again = AnswerStore(study / store.ANSWERS_FILE, load(study))
    assert [a.text for a in again.visits()[0].answers] == ["A"]


def test_the_fingerprint_is_computed_once(study: Path) -> None:
    made = load(study)
    assert made.fingerprint is made.fingerprint, "every visit has it"


def test_slots_are_assigned_evenly_and_kept_on_return(study: Path) -> None:
    made, opened = load(study), AnswerStore(study / store.ANSWERS_FILE, load(study))
    people = [f"{i:032x}" for i in range(5)]
    assert [opened.begin(Person(session=p)).slot for p in people] == [0, 1, 2, 0, 1]
    assert opened.begin(Person(session=people[2])).slot == 2
    for person, slot in zip(people[:3], range(3), strict=True):
        for step in range(len(made.slots[slot])):
            place = opened.keep(person, Answer(step=step, text=letter(made, slot, step), seconds=1))
        assert place
        assert place.code
    with pytest.raises(StudyFull):
        opened.begin(Person(session="f" * 32))
    assert opened.begin(Person(session=people[0])).code, "who has finished may read the code again"


def test_a_batch_is_full_before_the_next_is_invited(study: Path) -> None:
    made = load(study)

    def answer_all(opened: AnswerStore, person: str) -> None:
        slot = opened.begin(Person(session=person)).slot
        for step in range(len(made.slots[slot])):
            opened.keep(person, Answer(step=step, text=letter(made, slot, step), seconds=1))

    first = AnswerStore(study / store.ANSWERS_FILE, made, shares=2)
    for number in range(2):
        answer_all(first, f"{number:032x}")
    with pytest.raises(StudyFull):
        first.begin(Person(session=ANNE))
    first.close()
    second = AnswerStore(study / store.ANSWERS_FILE, made, shares=20)
    assert second.begin(Person(session=ANNE)).slot == 2
    assert second.withdraw(ANNE)
    assert not second.withdraw(ANNE)
    assert second.keep(ANNE, Answer(step=0, text="A", seconds=1)) is None
    assert second.begin(Person(session="b" * 32)).slot == 2, "who withdraws frees the share"


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (('title = "Questions about scenes"', ""), "texts.title is missing"),
        (("[texts]", '[texts]\nhint = "x"'), "texts.hint is unknown"),
        (("Picture {number}", "Bild {nummer}"), "`{nummer}` cannot stand here"),
        (('url = ""', 'url = "javascript:alert(1)"'), "completion.url"),
        (("[texts]", "[texts"), "cannot be read"),
    ],
)
def test_a_mistake_in_the_texts_of_the_page_is_an_error(change: tuple[str, str], message: str, study: Path) -> None:
    path = study / "texts/page.toml"
    path.write_text(path.read_text().replace(*change))
    with pytest.raises(WmsError) as raised:
        StudyServer(study, "127.0.0.1", 0)
    assert message in str(raised.value)
    assert "page.toml" in str(raised.value)


def test_answers_of_another_study_are_not_mixed_in(dataset: DatasetReader, study: Path, tmp_path: Path) -> None:
    AnswerStore(study / store.ANSWERS_FILE, load(study)).close()
    other = make(dataset, StudyOptions(per_task=2), tmp_path / "other")
    with pytest.raises(WmsError, match="another study"):
        AnswerStore(study / store.ANSWERS_FILE, other)


# ---------------------------------------------------------------- what is refused


@pytest.mark.parametrize(
    ("path", "body", "status"),
    [
        ("/visits", {"session": "x"}, 400),
        ("/visits", {"session": ANNE, "rater": "<script>"}, 400),
        ("/visits", {"session": ANNE, "rater": "a" * 65}, 400),
        ("/visits", {"session": ANNE, "admin": True}, 400),
        ("/visits", b"{", 400),
        ("/visits", b"\xff\xfe", 400),
        ("/visits", b"[" * 4000, 400),
        ("/visits", b"x" * (MAX_REQUEST_BYTES + 1), 413),
        (f"/visits/{ANNE}/answers", {"step": 0, "text": "A", "seconds": 1}, 409),
        (f"/visits/{ANNE}/answers", {"step": 0, "text": "<img src=x onerror=alert(1)>", "seconds": 1}, 400),
        (f"/visits/{ANNE}/answers", b'{"step": 0, "text": "A", "seconds": NaN}', 400),
        (f"/visits/{ANNE}/answers", {"step": -1, "text": "A", "seconds": 1}, 400),
        (f"/visits/{ANNE}/answers", {"step": 10**30, "text": "A", "seconds": 1}, 400),
        ("/", {}, 409),
    ],
)
def test_unknown_input_is_refused(path: str, body: object, status: int, port: int) -> None:
    assert post(port, path, body)[0] == status
    assert post(port, "/visits", {"session": ANNE})[0] == 200, "and it goes on"


def test_pages_of_others_cannot_speak_to_it(port: int) -> None:
    body = {"session": ANNE}
    assert post(port, "/visits", body, **{"Content-Type": "text/plain"})[0] == 415
    assert post(port, "/visits", body, Host="evil.example")[0] == 421
    assert get(port, "/", Host="evil.example")[0] == 421
    assert get(port, "/", Host=f"localhost:{port}")[0] == 200


@pytest.mark.parametrize(
    "path",
    [
        "/study.json",
        "/../study.json",
        "/pictures/../../study.json",
        "/pictures/%2e%2e/%2e%2e/study.json",
        "/pictures/..%2f..%2fstudy.json",
        "/pictures/",
        "/answers.sqlite",
        "/texts/consent.txt",
        "//etc/passwd",
    ],
)
def test_nothing_but_the_page_and_its_pictures_is_given(path: str, port: int) -> None:
    assert get(port, path)[0] == 404


def test_pictures_are_those_of_the_study(port: int, study: Path) -> None:
    for name in load(study).items[0].context:
        status, content = get(port, f"/pictures/{name}")
        assert status == 200
        assert content == (study / "page/pictures" / name).read_bytes()


def test_server_listens_on_the_loopback_address_by_default(study: Path) -> None:
    from wmspec.cli.study import serve_command

    host = next(p for p in serve_command.params if p.name == "host")
    assert host.default == "127.0.0.1"
    with StudyServer(study, "127.0.0.1", 0) as server:
        assert server.is_local
    with socket.create_server(("127.0.0.1", 0)) as other, pytest.raises(WmsError, match="try another --port"):
        StudyServer(study, "127.0.0.1", other.getsockname()[1])
    with StudyServer(study, "0.0.0.0", 0) as server:
        assert not server.is_local


def test_silent_or_lost_connection_blocks_no_other(port: int, capfd: pytest.CaptureFixture[str]) -> None:
    for said in (
        b"",
        b"POST /visits HTTP/1.1\r\nContent-Type: application/json\r\nContent-Length: 900\r\n\r\n{",
        b"\x00" * 99,
    ):
        with socket.create_connection(("127.0.0.1", port)) as visitor:
            visitor.sendall(said)
    assert post(port, "/visits", {"session": ANNE})[0] == 200
    assert "Traceback" not in capfd.readouterr().err
