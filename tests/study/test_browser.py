"""The study in a real browser, from consent to the completion code, as three raters would answer it."""

from __future__ import annotations

import csv
import json
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from click.testing import CliRunner

from tests.browser import PATIENCE, barriers
from tests.study.visitor import letter
from wmspec.cli import main
from wmspec.dataset.build.reader import DatasetReader
from wmspec.eval.study import store
from wmspec.eval.study.collect import collect
from wmspec.eval.study.make import StudyOptions, make
from wmspec.eval.study.model import Study, load
from wmspec.eval.study.serve import StudyServer
from wmspec.eval.study.store import AnswerStore

DESK: dict[str, Any] = {"viewport": {"width": 1024, "height": 700}}
PHONE: dict[str, Any] = {"viewport": {"width": 360, "height": 640}, "has_touch": True, "is_mobile": True}


@pytest.fixture
def study(dataset: DatasetReader, tmp_path: Path) -> Path:
    """Half as long as other tests have it: a browser draws each page."""
    make(dataset, StudyOptions(per_task=3, raters=3, check_every=3), tmp_path / "study")
    return tmp_path / "study"


@pytest.fixture
def url(study: Path) -> Iterator[str]:
    with StudyServer(study, "127.0.0.1", 0) as server:
        thread = threading.Thread(target=server.serve_forever)
        thread.start()
        yield server.url
        server.shutdown()
        thread.join()


class Rater:
    """Somebody at a page, who is right or `off` by a number of places; page errors are collected."""

    def __init__(self, browser: Any, url: str, study: Study, off: int = 0, **how: Any) -> None:
        self.study, self.off, self.touch = study, off, how.get("has_touch", False)
        self.context = browser.new_context(**(how or DESK))
        self.context.set_default_timeout(PATIENCE)
        self.tab = self.context.new_page()
        self.complaints: list[str] = []
        self.tab.on("pageerror", lambda error: self.complaints.append(str(error)))
        self.tab.on("console", lambda said: self.complaints.append(said.text))
        self.origin = url.partition("?")[0].rpartition("/")[0]
        self.tab.on(
            "request", lambda outgoing: self.complaints.append(outgoing.url) if self._is_foreign(outgoing.url) else None
        )
        self.tab.goto(url)

    def _is_foreign(self, url: str) -> bool:
        return not url.startswith((self.origin, "blob:", "data:"))

    def kept(self) -> dict[str, Any]:
        """What the browser keeps of the visit."""
        found = self.tab.evaluate("Object.values(localStorage)[0] ?? '{}'")
        return dict(json.loads(found))

    def step(self) -> bool:
        """One page. False when there is none left."""
        self.tab.wait_for_selector("main form, #code")
        form = self.tab.query_selector("main form")
        if form is None:
            return False
        if not self.tab.query_selector("input[type=radio]"):
            self.press(self.tab.locator("form [type=submit]"))
        else:
            self.tab.wait_for_selector("form[data-ready]")
            step = int(form.get_attribute("data-step"))
            self.answer(step)
            if self.tab.query_selector("input:disabled"):
                self.feedback()
        self.tab.wait_for_function("form => !form.isConnected", arg=form)
        return True

    def answer(self, step: int) -> None:
        slot = self.kept()["slot"]
        shown = self.study.step(slot, step)
        assert shown is not None
        expected = letter(self.study, slot, step, self.off if shown[0].kind == "question" else 0)
        button = self.tab.locator("form [type=submit]")
        assert button.is_disabled()
        if self.touch:
            self.tab.locator(f".option:has([value={expected}])").tap()
            button.tap()
        else:
            self.tab.keyboard.press(expected.lower() if step % 2 else str("ABCDEF".index(expected) + 1))
            self.tab.keyboard.press("Enter")

    def feedback(self) -> None:
        assert self.tab.inner_text(".said") == "That is right."
        assert self.tab.locator(".option.true").count() == 1
        self.press(self.tab.locator("form [type=submit]"))

    def press(self, button: Any) -> None:
        if self.touch:
            button.tap()
        else:
            button.click()

    def finish(self, troubled: bool = False) -> str:
        """Go on to the end. The completion code. The browser must not complain, unless the server was `troubled`."""
        while self.step():
            pass
        code = str(self.tab.inner_text("#code"))
        assert troubled or not self.complaints
        return code


def test_three_raters_from_consent_to_the_code(browser: Any, url: str, study: Path) -> None:
    """At a desk with the keyboard, and on a phone with taps."""
    made, codes = load(study), []
    for name, how, off in (("anne", DESK, 0), ("ben", PHONE, 0), ("carl", PHONE, 1)):
        rater = Rater(browser, f"{url}?rater={name}", made, off, **how)
        assert "Before you begin" in rater.tab.inner_text("h1")
        codes.append(rater.finish())
        assert rater.tab.evaluate("document.documentElement.scrollWidth <= innerWidth")
        rater.context.close()
    collected = collect(study, (), study / "r.parquet")
    assert collected.missing == 0
    by_name = {rater.rater: rater for rater in collected.raters}
    assert [by_name[name].code for name in ("anne", "ben", "carl")] == codes
    assert [by_name[name].right for name in ("anne", "ben", "carl")] == [6, 6, 0]
    assert all(r.checks_passed == r.checks > 0 and r.seconds is not None and r.seconds > 0 for r in collected.raters)
    for agreed in collected.agreement:
        assert agreed.majority == 1
        assert agreed.alpha is not None


def test_a_reload_goes_on_with_the_same_question(browser: Any, url: str, study: Path) -> None:
    rater = Rater(browser, url, load(study))
    for _ in range(6):
        rater.step()
    rater.tab.wait_for_selector("form[data-step]")
    before = rater.tab.get_attribute("form", "data-step")
    rater.tab.reload()
    while not rater.tab.query_selector("form[data-step]"):
        rater.step()
    assert rater.tab.get_attribute("form", "data-step") == before
    rater.finish()
    (visit,) = AnswerStore(study / store.ANSWERS_FILE, load(study)).visits()
    assert [answer.step for answer in visit.answers] == list(range(len(load(study).slots[0])))
    rater.tab.reload()
    assert rater.tab.inner_text("#code") == visit.code


def test_seconds_under_a_clock_that_jumps(browser: Any, url: str, study: Path) -> None:
    """Answers take as long as they take, independent of the wall clock of the computer."""
    rater, began = Rater(browser, url, load(study)), time.monotonic()
    rater.tab.evaluate(
        """() => {
          const now = Date.now;
          let reads = 0;
          Date.now = () => now() + 864e5 * (reads++ % 2 ? 1 : -1) * reads;
          Date = class extends Date { constructor(...given) { super(...(given.length ? given : [Date.now()])); } };
        }"""
    )
    rater.finish()
    elapsed = time.monotonic() - began
    (visit,) = AnswerStore(study / store.ANSWERS_FILE, load(study)).visits()
    assert [answer.step for answer in visit.answers] == list(range(len(load(study).slots[0])))
    assert all(answer.seconds > 0 for answer in visit.answers)
    assert sum(answer.seconds for answer in visit.answers) <= elapsed


def test_answers_wait_while_the_server_is_away(browser: Any, study: Path) -> None:
    made = load(study)
    server = StudyServer(study, "127.0.0.1", 0)
    port = server.server_address[1]

    def serve(one: StudyServer) -> threading.Thread:
        thread = threading.Thread(target=one.serve_forever)
        thread.start()
        return thread

    thread = serve(server)
    rater = Rater(browser, server.url, made)
    rater.tab.wait_for_selector("main form")
    for _ in range(4):
        rater.step()
    rater.tab.route("**/answers", lambda route: route.abort())
    rater.step()
    rater.tab.wait_for_function("() => document.getElementById('trouble').textContent.includes('kept here')")
    server.shutdown()
    thread.join()
    server.server_close()
    again = StudyServer(study, "127.0.0.1", port)
    thread = serve(again)
    rater.tab.unroute("**/answers")
    rater.finish(troubled=True)
    again.shutdown()
    thread.join()
    again.server_close()
    assert collect(study, (), study / "r.parquet").replies == 6


def test_a_file_without_a_server_gives_its_answers(browser: Any, study: Path, tmp_path: Path) -> None:
    made, address = load(study), (study / "page/index.html").as_uri()
    for slot in range(3):
        rater = Rater(browser, f"{address}?slot={slot + 1}", made, **(PHONE if slot else DESK))
        for _ in range(5):
            rater.step()
        rater.tab.reload()
        code = rater.finish()
        with rater.tab.expect_download() as saved:
            rater.press(rater.tab.locator("#save"))
        saved.value.save_as(tmp_path / f"{slot}.json")
        assert json.loads((tmp_path / f"{slot}.json").read_text())["code"] == code
        rater.context.close()
    collected = collect(study, sorted(tmp_path.glob("*.json")), tmp_path / "r.parquet")
    assert (collected.replies, collected.missing) == (18, 0)
    assert all(rater.right == 6 for rater in collected.raters)


def test_participant_without_consent_is_not_recorded(browser: Any, url: str, study: Path) -> None:
    rater = Rater(browser, url, load(study))
    rater.tab.locator("#decline").click()
    assert rater.tab.inner_text("h1") == "You did not agree"
    assert not rater.tab.is_visible("#withdraw")
    assert rater.kept() == {}
    assert not AnswerStore(study / store.ANSWERS_FILE, load(study)).visits()
    assert not rater.complaints


def test_withdrawal_deletes_all_answers(browser: Any, url: str, study: Path) -> None:
    rater, stays = Rater(browser, url, load(study)), Rater(browser, f"{url}?rater=stays", load(study))
    for one in (stays, rater):
        for _ in range(6):
            one.step()
    answers = AnswerStore(study / store.ANSWERS_FILE, load(study))
    session = str(rater.kept()["session"])
    assert session in {visit.session for visit in answers.visits()}
    rater.tab.locator("#withdraw").click()
    rater.tab.locator("#leave [value=no]").click()
    rater.step()
    rater.tab.locator("#withdraw").click()
    rater.tab.locator("#leave [value=yes]").click()
    rater.tab.wait_for_function("() => document.querySelector('h1')?.textContent === 'You have withdrawn'")
    assert rater.kept() == {}
    assert [visit.rater for visit in answers.visits()] == ["stays"]
    answers.close()
    assert session.encode() not in (study / store.ANSWERS_FILE).read_bytes()
    assert not rater.complaints
    stays.finish()


def test_people_of_prolific_and_mechanical_turk(browser: Any, study: Path, tmp_path: Path) -> None:
    """Ids come with the link, the code is the fixed one, a link leads back, and the sheet says who is to be paid."""
    wording = study / "texts/page.toml"
    back = "https://app.prolific.com/submissions/complete?cc=C1A2B3"
    changed = wording.read_text().replace('code = ""', 'code = "C1A2B3"').replace('url = ""', f'url = "{back}"')
    wording.write_text(changed.replace("Thank you!", "Danke!").replace('"en"', '"de"'))
    links = {
        "anne": "PROLIFIC_PID=anne&STUDY_ID=s1&SESSION_ID=x1",
        "ben": "workerId=ben&hitId=h1&assignmentId=a1",
        "carl": "rater=carl",
    }
    with StudyServer(study, "127.0.0.1", 0) as server:
        thread = threading.Thread(target=server.serve_forever)
        thread.start()
        for name, link in links.items():
            rater = Rater(browser, f"{server.url}?{link}", load(study))
            if name == "carl":
                for _ in range(6):
                    rater.step()
                continue
            assert rater.finish() == "C1A2B3"
            assert rater.tab.get_attribute("#return", "href") == back
            assert (rater.tab.inner_text("h1"), rater.tab.get_attribute("html", "lang")) == ("Danke!", "de")
        server.shutdown()
        thread.join()
    sheet = tmp_path / "pay.csv"
    args = ["study", "collect", str(study), "-o", str(tmp_path / "r.parquet"), "--payments", str(sheet)]
    done = CliRunner().invoke(main, args)
    assert done.exit_code == 0, done.output
    with sheet.open(newline="") as file:
        lines = {line["rater"]: line for line in csv.DictReader(file)}
    assert {name: (line["study_id"], line["session_id"], line["verdict"]) for name, line in lines.items()} == {
        "anne": ("s1", "x1", "pay"),
        "ben": ("h1", "a1", "pay"),
        "carl": ("", "", "incomplete"),
    }


@pytest.mark.parametrize("how", [DESK, PHONE], ids=["desk", "phone"])
def test_there_are_no_barriers(browser: Any, url: str, study: Path, how: dict[str, Any]) -> None:
    """From consent through the instructions, a practice question and its feedback, to a question."""
    rater = Rater(browser, url, load(study), **how)
    for _ in range(6):
        assert barriers(rater.tab) == []
        rater.step()


def test_texts_are_shown_as_they_are(browser: Any, study: Path) -> None:
    from wmspec.eval.study import page

    bad = "# <img src=x onerror=alert(1)>\n\n</script><script>alert(2)</script>\n\n\u2028 ${alert(3)} {{ script }}"
    (study / "texts/consent.txt").write_text(bad)
    (study / "page/index.html").write_text(page.html(load(study), study, served=False))
    rater = Rater(browser, (study / "page/index.html").as_uri(), load(study))
    rater.tab.on("dialog", lambda dialog: rater.complaints.append(dialog.message))
    assert rater.tab.inner_text("h1") == "<img src=x onerror=alert(1)>"
    assert rater.tab.locator("main img, main script").count() == 0
    assert not rater.complaints
