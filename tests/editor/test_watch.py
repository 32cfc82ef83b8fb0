"""`wmspec watch`: the page follows the file, whatever is saved, and loads nothing from elsewhere."""

from __future__ import annotations

import http.client
import threading
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

from tests.browser import PATIENCE, barriers
from tests.engines import installed
from wmspec.api.loading import TextCheck
from wmspec.core.diagnostics import WmsError
from wmspec.editor.page import PageServer
from wmspec.editor.start import first_spec
from wmspec.editor.watch import PreviewOptions, State, Watch, picture_name


@dataclass
class Page:
    path: Path
    watch: Watch
    server: PageServer

    def settled(self, after: int) -> State:
        """The first state after a version in which nothing is under way."""
        while True:
            state = self.watch.after(after, PATIENCE / 1000)
            assert state is not None
            if state.phase == "done":
                return state
            after = state.version


@pytest.fixture(scope="module")
def served(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Page]:
    installed("mujoco")
    path = tmp_path_factory.mktemp("watch") / "marbles.wms"
    path.write_text(first_spec("marbles", "perception"))
    watch = Watch(path, PreviewOptions("mujoco", instances=2, size=64))
    server = PageServer(watch, 0)
    threads = [threading.Thread(target=watch.run), threading.Thread(target=server.serve_forever, args=(0.05,))]
    for thread in threads:
        thread.start()
    yield Page(path, watch, server)
    watch.stop()
    server.shutdown()
    server.server_close()
    for thread in threads:
        thread.join()


@pytest.mark.engine
@pytest.mark.pixels
def test_it_follows_the_file(served: Page) -> None:
    good = first_spec("marbles", "perception")
    state = served.settled(-1)
    assert not state.diagnostics
    assert state.tasks == (("marbles", 90),)
    rows = state.rows
    assert len(rows) == 2
    assert all(cell.png for row in rows for each in row.questions for cell in each.context)
    assert [sum(cell.true for cell in each.options) for row in rows for each in row.questions] == [1, 1]

    served.path.write_text(good.replace("size: if", "siez: if"))
    broken = served.settled(state.version)
    assert {d.code for d in broken.diagnostics} >= {"WMS203"}
    assert (broken.stale, broken.rows) == (True, rows), "what was drawn stays, and is said to be old"

    served.path.write_bytes(b"\xff\xfe")
    unreadable = served.settled(broken.version)
    assert "UTF-8" in unreadable.diagnostics[0].message

    served.path.write_text(good.replace("repeat 10", "repeat 3"))
    fixed = served.settled(unreadable.version)
    assert (fixed.diagnostics, fixed.stale) == ((), False)
    assert fixed.tasks == (("marbles", 27),)


def test_file_may_vanish_before_its_mistakes_are_reported(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "gone.wms"
    path.write_text("task t : custom { objekt }")

    def then_gone(text: str, at: Path) -> TextCheck:
        path.write_bytes(b"\xff\xfe")
        return TextCheck(text, at)

    monkeypatch.setattr("wmspec.editor.watch.TextCheck", then_gone)
    watch = Watch(path, PreviewOptions("mujoco", instances=1, size=32))
    page = Page(path, watch, PageServer(watch, 0))
    worker = threading.Thread(target=watch.run)
    worker.start()
    mistaken = page.settled(-1)
    unreadable = page.settled(mistaken.version)
    watch.stop()
    page.server.server_close()
    worker.join()
    assert mistaken.diagnostics[0].code
    assert "UTF-8" in unreadable.diagnostics[0].message


@pytest.mark.engine
@pytest.mark.pixels
def test_pictures_of_a_page_outlive_the_next_sheet(served: Page) -> None:
    good = first_spec("marbles", "perception")
    sheets = []
    for text in (good, good.replace("in [red, orange, yellow]", "in [purple]")):
        version = served.watch.state.version
        served.path.write_text(text + "\n")
        rows = served.settled(version).rows
        sheets.append(
            {picture_name(c.png) for row in rows for a in row.questions for c in (*a.context, *a.options) if c.png}
        )
    assert sheets[0] - sheets[1]
    assert all(served.watch.png(name) for name in sheets[0] | sheets[1])


def test_only_this_machine_by_its_own_name_is_answered(served: Page) -> None:
    host, port = served.server.server_address[:2]
    assert host == "127.0.0.1"
    for name, status in ((f"127.0.0.1:{port}", 200), (f"localhost:{port}", 200), ("bent.example", 403)):
        connection = http.client.HTTPConnection("127.0.0.1", port)
        connection.request("GET", "/", headers={"Host": name})
        assert connection.getresponse().status == status
        connection.close()
    with pytest.raises(WmsError, match="cannot be used"):
        PageServer(served.watch, port)


@pytest.mark.engine
@pytest.mark.pixels
@pytest.mark.browser
def test_page_lists_it(served: Page, browser: Any) -> None:
    good = first_spec("marbles", "perception")
    served.path.write_text(good)
    context = browser.new_context(viewport={"width": 1100, "height": 900})
    context.set_default_timeout(PATIENCE)
    page = context.new_page()
    complaints: list[str] = []
    page.on("pageerror", lambda error: complaints.append(str(error)))
    page.on("console", lambda message: complaints.append(message.text))
    page.on("request", lambda r: None if r.url.startswith((served.server.url, "data:")) else complaints.append(r.url))
    page.goto(served.server.url)
    page.wait_for_selector("#rows:not(.stale) article >> nth=1")
    page.wait_for_selector("#phase.good")
    sizes = page.evaluate("Promise.all([...document.images].map((i) => i.decode().then(() => i.naturalWidth)))")
    assert set(sizes) == {64}
    assert page.inner_text("#tasks") == "marbles: 90 instances"
    assert page.locator(".option.true").count() == 2
    assert barriers(page) == []
    served.path.write_text(good.replace("color: one", "color: <b>one"))
    page.wait_for_selector("pre.error")
    assert "<b>" in page.inner_text("pre.error >> nth=0")
    assert page.locator("#rows.stale article").count() == 2
    served.path.write_text(good.replace("in [red, orange, yellow]", "in [purple]"))
    page.wait_for_selector("#diagnostics pre", state="detached")
    page.wait_for_selector("#phase.good")
    page.wait_for_selector("#rows:not(.stale) article")
    assert page.locator("#diagnostics pre").count() == 0
    assert not complaints
    context.close()
