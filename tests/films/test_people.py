"""Films as people see them: in the gallery, on the contact sheet, and in a study."""

from __future__ import annotations

import json
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from tests.browser import opened
from tests.study.test_browser import Rater
from tests.study.visitor import get
from wmspec.dataset.build.films import shown_film
from wmspec.dataset.build.reader import DatasetReader
from wmspec.dataset.build.sheet import contact_sheet
from wmspec.eval.gallery.gallery import folder, page
from wmspec.eval.study.make import StudyOptions, make
from wmspec.eval.study.model import load
from wmspec.eval.study.serve import StudyServer

#: A film has its last frame and plays through.
PLAYS = """video => new Promise(done => { video.loop = false; video.playbackRate = 1;
    video.addEventListener('ended', () => done(video.duration)); video.play(); })"""

#: Read at once in the page: the film may end at any moment.
BEFORE_THE_END_NOTHING_CAN_BE_CHOSEN = (
    "document.querySelector('video').ended || document.querySelector('fieldset').disabled"
)


@pytest.fixture(scope="module")
def dataset(films: Path) -> DatasetReader:
    return DatasetReader.open(films)


@pytest.fixture(params=["page", "folder"])
def gallery(request: pytest.FixtureRequest, dataset: DatasetReader, tmp_path: Path, browser: Any) -> Iterator[Any]:
    if request.param == "page":
        page(dataset, 1, tmp_path / "gallery.html")
        yield from opened(browser, tmp_path / "gallery.html")
    else:
        folder(dataset, 1, tmp_path / "gallery")
        yield from opened(browser, tmp_path / "gallery/index.html")


def test_the_gallery_plays_what_is_shown_and_then_what_happens(gallery: Any, dataset: DatasetReader) -> None:
    task = dataset.tasks[0]
    row = next(iter(dataset.rows(task)))
    film = shown_film(dataset.folder, row)
    assert film is not None
    lasted = gallery.locator("video").first.evaluate(PLAYS)
    assert lasted == pytest.approx(film.count / film.rate, abs=0.02)
    gallery.get_by_role("button", name="Show the truth").first.click()
    lasted = gallery.locator("video").first.evaluate(PLAYS)
    assert lasted == pytest.approx((row["film_answer"] + 1) / film.rate, abs=0.02)


def test_the_sheet_has_a_strip_of_the_film(films: Path, dataset: DatasetReader) -> None:
    with_film = contact_sheet(films, 1)
    assert with_film.height > 900
    colours = {with_film.getpixel((x, with_film.height - 160)) for x in range(0, with_film.width, 7)}
    assert len(colours) > 20  # pictures, not paper


@pytest.fixture
def study(dataset: DatasetReader, tmp_path: Path) -> Path:
    make(dataset, StudyOptions(per_task=2, raters=1, practice=1, check_every=0), tmp_path / "study")
    return tmp_path / "study"


def test_people_choose_when_the_film_has_ended(study: Path, browser: Any) -> None:
    made = load(study)
    shown = [item for item in made.items if item.film]
    assert shown, "no question of the study has a film"
    assert not any(item.context for item in shown), "pictures of the film's camera are shown twice"
    with StudyServer(study, "127.0.0.1", 0) as server:
        thread = threading.Thread(target=server.serve_forever)
        thread.start()
        try:
            rater = Rater(browser, f"{server.url}?rater=anne", made)
            while not rater.tab.query_selector("video"):
                rater.step()
            assert rater.tab.evaluate(BEFORE_THE_END_NOTHING_CAN_BE_CHOSEN)
            rater.finish()
            rater.context.close()
            status, part = get(server.server_address[1], f"/films/{shown[0].film}", Range="bytes=4-7")
        finally:
            server.shutdown()
            thread.join()
    assert (status, part) == (206, b"ftyp")
    assert "short film" in next((study / "texts").glob("task-*.txt")).read_text()
    items = json.loads((study / "study.json").read_text())["items"]
    assert {item["film"].rpartition(".")[2] for item in items if item.get("film")} == {"mp4"}
