"""The report as a user gets it: exit codes, a page that stands alone, the same bytes again."""

from __future__ import annotations

import json
import re
from html.parser import HTMLParser
from pathlib import Path

import pytest

from tests.audit.made import make, race
from tests.command import wmspec


class Page(HTMLParser):
    """What a page loads, and whether its tags are closed in order."""

    def __init__(self) -> None:
        super().__init__()
        self.open: list[str] = []
        self.loads: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.loads += [v or "" for k, v in attrs if k in ("src", "href") and v != "data:,"]
        if tag not in ("meta", "br", "link"):
            self.open.append(tag)

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        """A tag that is closed at once."""

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag


@pytest.mark.usefixtures("roughly")
def test_an_unsound_dataset(tmp_path: Path) -> None:
    make(tmp_path / "leaky", "race", race(level=True), 100)
    message = wmspec("audit", "leaky", "-o", "report", folder=tmp_path, code=1).stdout
    assert re.search(
        r"fails: shortcut race: from the best single picture \(picture 2: pixels\) alone, \d+% of 100 right", message
    )
    found = json.loads((tmp_path / "report/audit.json").read_text())
    assert not found["passed"]
    assert found["findings"][0]["verdict"] == "fails"
    page = Page()
    page.feed((tmp_path / "report/audit.html").read_text())
    assert not page.open
    assert not page.loads, "the page stands alone"
    assert str(tmp_path) not in (tmp_path / "report/audit.html").read_text()


@pytest.mark.usefixtures("roughly")
def test_of_a_sound_dataset_the_same_bytes_again_and_json_for_machines(tmp_path: Path) -> None:
    make(tmp_path / "made", "race", race(), 24)
    assert "Of 1 task, 1 " in wmspec("audit", "made", "-o", "a", folder=tmp_path).stdout
    said = wmspec("audit", "made", "-o", "b", "--json", folder=tmp_path).stdout
    for name in ("audit.json", "audit.html"):
        assert (tmp_path / "a" / name).read_bytes() == (tmp_path / "b" / name).read_bytes()
    assert said == (tmp_path / "a/audit.json").read_text()
    result = json.loads(said)
    assert result["passed"]
    assert result["format"] == 2
    assert {f["verdict"] for f in result["findings"]} <= {"fails", "unclear", "reported", "holds"}


def test_a_damaged_dataset_fails_and_is_not_shown(tmp_path: Path) -> None:
    make(tmp_path / "made", "race", race(), 60)
    (shard,) = (tmp_path / "made/data/race").iterdir()
    content = bytearray(shard.read_bytes())
    content[len(content) // 2] ^= 1
    shard.write_bytes(content)
    wmspec("audit", "made", folder=tmp_path, code=1)
    assert {p.name for p in tmp_path.iterdir()} == {"made"}, "without -o nothing is written"
    found = json.loads(wmspec("audit", "made", "-o", "report", "--json", folder=tmp_path, code=1).stdout)
    assert [(f["check"], f["verdict"]) for f in found["findings"]] == [("files", "fails")]
    assert shard.name in (tmp_path / "report/audit.html").read_text()
    for output in ("page.html", "folder", "sheet.png"):
        message = wmspec("view", "made", "-o", output, folder=tmp_path, code=2).stderr
        assert f"{shard.name} was modified; run the command that made the dataset again" in message
        assert not (tmp_path / output).exists()


def test_dataset_that_cannot_be_audited_is_an_error(tmp_path: Path) -> None:
    assert "no finished dataset" in wmspec("audit", "nowhere", folder=tmp_path, code=2).stderr
