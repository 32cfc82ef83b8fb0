"""A dataset of two tasks in three engines, its gallery, and a browser to look at it."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from tests.dataset.made import make, plan
from wmspec.gallery.gallery import folder
from wmspec.write.reader import DatasetReader

PATIENCE = 600_000.0  # ms: what ends a test that hangs, and no test of how busy the machine is
BROWSERS = ("chromium", "chromium-browser", "google-chrome")


@pytest.fixture(scope="session")
def dataset(tmp_path_factory: pytest.TempPathFactory) -> DatasetReader:
    place = tmp_path_factory.mktemp("dataset")
    make(place, plan(count=20, shard=8))
    return DatasetReader.open(place)


@pytest.fixture(scope="session")
def gallery(dataset: DatasetReader, tmp_path_factory: pytest.TempPathFactory) -> Path:
    place = tmp_path_factory.mktemp("gallery")
    folder(dataset, 20, place)
    return place / "index.html"


@pytest.fixture(scope="session")
def browser() -> Iterator[Any]:
    playwright = pytest.importorskip("playwright.sync_api")
    found = next(filter(None, map(shutil.which, BROWSERS)), None)
    if found is None:
        pytest.skip("there is no Chromium here; on Debian: sudo apt-get install chromium")
    with playwright.sync_playwright() as started:
        chromium = started.chromium.launch(executable_path=found, args=["--no-sandbox"], timeout=PATIENCE)
        yield chromium
        chromium.close()


@pytest.fixture
def page(browser: Any, gallery: Path) -> Iterator[Any]:
    yield from opened(browser, gallery)


def opened(browser: Any, path: Path, **how: Any) -> Iterator[Any]:
    """A page that must not complain, nor load anything that is not beside it."""
    context = browser.new_context(viewport={"width": 1280, "height": 1000}, **how)
    context.set_default_timeout(PATIENCE)
    tab = context.new_page()
    complaints: list[str] = []
    tab.on("pageerror", lambda error: complaints.append(str(error)))
    tab.on("console", lambda said: complaints.append(said.text))
    tab.on("request", lambda asked: None if asked.url.startswith(("file:", "data:")) else complaints.append(asked.url))
    tab.on("requestfailed", lambda asked: complaints.append(f"{asked.url} cannot be had"))
    tab.goto(path.as_uri())
    yield tab
    context.close()
    assert not complaints
