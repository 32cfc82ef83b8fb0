"""A browser to look at pages."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

PATIENCE = 600_000.0  # ms: what ends a test that hangs, and no test of how busy the machine is
BROWSERS = ("chromium", "chromium-browser", "google-chrome")


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


def opened(browser: Any, path: Path, **how: Any) -> Iterator[Any]:
    """A page that must not complain, nor load anything that is not beside it."""
    context = browser.new_context(viewport={"width": 1280, "height": 1000}, **how)
    context.set_default_timeout(PATIENCE)
    tab = context.new_page()
    complaints: list[str] = []
    tab.on("pageerror", lambda error: complaints.append(str(error)))
    tab.on("console", lambda said: complaints.append(said.text))
    tab.on(
        "request",
        lambda outgoing: None if outgoing.url.startswith(("file:", "data:")) else complaints.append(outgoing.url),
    )
    tab.on("requestfailed", lambda outgoing: complaints.extend(_missed(outgoing)))
    tab.goto(path.as_uri())
    yield tab
    context.close()
    assert not complaints, complaints


def barriers(tab: Any) -> list[str]:
    """What axe-core finds serious or critical for people with disabilities on the page as it is now."""
    axe = pytest.importorskip("axe_playwright_python.sync_playwright")
    found = axe.Axe().run(tab).response["violations"]
    return [
        f"{each['id']}: {each['help']} ({node['html']})"
        for each in found
        if each["impact"] in ("serious", "critical")
        for node in each["nodes"]
    ]


def _missed(outgoing: Any) -> list[str]:
    """The resource that failed to load; a page that is left or reloaded cancels its requests."""
    return [] if outgoing.failure == "net::ERR_ABORTED" else [f"{outgoing.url} cannot be had: {outgoing.failure}"]
