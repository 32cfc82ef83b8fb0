"""What is in the gallery, without a browser."""

from __future__ import annotations

import json
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import pytest

from tests.command import wmspec
from wmspec.dataset.build.format_units import format_reading, format_value
from wmspec.dataset.build.reader import DatasetReader
from wmspec.eval.gallery.gallery import folder, html, page
from wmspec.eval.gallery.records import about, records


def test_every_instance_once_with_every_engine(dataset: DatasetReader) -> None:
    found = list(records(dataset, 100, lambda png: "x"))
    assert len({q["id"] for q in found}) == len(found) == dataset.manifest["rows"] / 3
    for question in found:
        assert [run["engine"] for run in question["runs"]] == list(dataset.engines)
        assert question["agreement"] == "all agree"
        for run in question["runs"]:
            assert run["options"][run["true"]]["kind"] == "truth"


def test_few_are_spread_over_the_task(dataset: DatasetReader) -> None:
    few = list(records(dataset, 4, lambda png: "x"))
    assert len(few) == 8
    every = [q["index"] for q in records(dataset, 100, lambda png: "x") if q["task"] == "collide"]
    some = [q["index"] for q in few if q["task"] == "collide"]
    assert some == [every[i * len(every) // 4] for i in range(4)]


def test_an_engine_that_differs_is_seen(dataset: DatasetReader, monkeypatch: pytest.MonkeyPatch) -> None:
    rows = DatasetReader.rows

    def differing(self: DatasetReader, *args: Any, **more: Any) -> Any:
        for row in rows(self, *args, **more):
            if "agreement" in row and row["engine"] == "sapien":
                row["agreement"][0]["answer"] = (row["answer"] + 1) % 2
            yield row

    monkeypatch.setattr(DatasetReader, "rows", differing)
    assert {q["agreement"] for q in records(dataset, 5, lambda png: "x")} == {"some differ"}


def test_the_same_bytes_again(dataset: DatasetReader, tmp_path: Path) -> None:
    page(dataset, 3, tmp_path / "a.html")
    page(dataset, 3, tmp_path / "b.html")
    assert (tmp_path / "a.html").read_bytes() == (tmp_path / "b.html").read_bytes()
    folder(dataset, 3, tmp_path / "c")
    assert {p.suffix for p in (tmp_path / "c").rglob("*") if p.is_file()} <= {".html", ".png", ".webp"}


class Scripts(HTMLParser):
    """The texts of a page's scripts."""

    def __init__(self) -> None:
        super().__init__()
        self.texts: list[str] = []
        self.inside = False

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.inside = tag == "script"

    def handle_data(self, data: str) -> None:
        if self.inside:
            self.texts.append(data)

    def handle_endtag(self, tag: str) -> None:
        self.inside = False


def test_no_text_of_a_spec_can_break_out(dataset: DatasetReader) -> None:
    wicked = "</script><script>alert(1)</script> {{ script }} <!--"
    scripts = Scripts()
    scripts.feed(html(about(dataset) | {"name": wicked, "questions": []}))
    assert len(scripts.texts) == 2
    assert json.loads(scripts.texts[0])["name"] == wicked


def test_values_in_words() -> None:
    assert format_value(0.2, "m/s") == "20 cm/s"
    assert format_value(0.5236, "rad") == "30°"
    assert format_value([0.1, 0.25], "m") == "(10, 25) cm"
    assert format_value(True) == "yes"
    assert format_value("red") == "red"
    assert format_reading("speed(ball)", 0.31) == "31 cm/s"
    assert format_reading("contact(a, b)", 1.0) == "yes"


@pytest.mark.parametrize(
    ("args", "said"),
    [
        (["nowhere"], "no finished dataset"),
        ([".", "-o", "x.pdf"], "expected .html for a page"),
        ([".", "-o", "/proc/x"], "/proc/x"),
    ],
)
def test_unshowable_datasets_are_errors(args: list[str], said: str, dataset: DatasetReader, tmp_path: Path) -> None:
    args = [str(dataset.folder) if a == "." else a for a in args]
    assert said in wmspec("view", *args, folder=tmp_path, code=2).stderr


def test_a_page_from_the_command_line(dataset: DatasetReader, tmp_path: Path) -> None:
    assert "questions; open it in a browser" in wmspec("view", dataset.folder, folder=tmp_path).stdout
    assert (tmp_path / "gallery.html").stat().st_size > 10_000
