"""What the gallery lets one do beyond answering: look closely, sort, compare with models, take notes, come back."""

from __future__ import annotations

import io
import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

from tests.browser import opened
from tests.command import wmspec
from tests.gallery.test_browser import chosen, counted, questions
from wmspec.dataset.build.images import encode_png
from wmspec.dataset.build.reader import DatasetReader
from wmspec.eval.gallery.gallery import folder, html
from wmspec.eval.gallery.records import about, paths, read, records
from wmspec.eval.models import results


@pytest.fixture(scope="session")
def answered(dataset: DatasetReader, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Results of a model that guesses, and of one that knows."""
    place = tmp_path_factory.mktemp("results")
    for model in ("random", "oracle"):
        wmspec("evaluate", dataset.folder, "-m", model, "-o", place / f"{model}.parquet", folder=place)
    return place


@pytest.fixture
def compared(browser: Any, dataset: DatasetReader, answered: Path, tmp_path: Path) -> Iterator[tuple[Any, Path]]:
    """A gallery with answers of models, everything that can lie beside the page beside it."""
    folder(dataset, 20, tmp_path / "g", read([answered]), inside=5)
    for tab in opened(browser, tmp_path / "g/index.html"):
        tab.wait_for_selector("article")
        yield tab, tmp_path / "g"


def canvas(page: Any) -> np.ndarray:
    """What is drawn, as a person sees it."""
    page.evaluate("document.activeElement.blur()")
    return np.asarray(Image.open(io.BytesIO(page.locator("#canvas").screenshot())).convert("RGB"), int)[2:-2, 2:-2]


# ---------------------------------------------------------------- pictures, large


def test_pictures_are_seen_large_and_beside_another(page: Any) -> None:
    chosen(page, "collide")
    page.locator("article figure button").first.click()
    page.wait_for_function("() => document.querySelector('#canvas').width === 64")
    assert page.inner_text("#caption") == "mujoco: front, 0 s"
    shown = canvas(page)
    page.keyboard.press("Space")
    assert page.inner_text("#caption") == "mujoco: front, 0.2 s"
    assert (canvas(page) != shown).any()
    before = page.inner_text("#scale")
    page.keyboard.press("-")
    assert float(page.inner_text("#scale")[:-1]) == float(before[:-1]) / 2
    page.keyboard.press("ArrowRight")
    assert page.inner_text("#caption") == "mujoco: front, 0.2 s"
    page.keyboard.press("Escape")
    assert not page.locator("#viewer").is_visible()
    assert page.inner_text("#score") == "", "keys that look answer nothing"


def test_a_difference_is_black_where_nothing_differs(page: Any) -> None:
    chosen(page, "collide")
    page.keyboard.press("z")
    page.wait_for_function("() => document.querySelector('#canvas').width === 64")
    page.keyboard.press("d")
    assert "−" in page.inner_text("#caption")
    differing = canvas(page)
    assert differing.max() > 100
    assert np.median(differing) == 0, "most of it is the same"
    page.select_option("#second", "0")
    assert canvas(page).max() == 0


def test_pictures_flicker_until_stopped(page: Any) -> None:
    page.keyboard.press("z")
    page.keyboard.press("x")
    first = page.inner_text("#caption")
    page.wait_for_function("said => document.querySelector('#caption').textContent !== said", arg=first)
    page.keyboard.press("Escape")
    page.wait_for_function("() => document.querySelector('#flicker').ariaPressed === 'false'")  # closing takes a moment
    assert page.get_attribute("#flicker", "aria-pressed") == "false"


def test_ways_are_those_of_what_moves() -> None:
    def ids(x: int) -> np.ndarray:
        seen = np.zeros((20, 40), np.uint16)
        seen[2:5, 30:33] = 1  # stands still
        seen[10:13, x : x + 3] = 2
        return seen

    row = {
        "context_ids": [{"bytes": encode_png(ids(x))} for x in (3, 8, 20)],
        "context_names": ["post", "ball"],
        "context_camera": ["front"] * 3,
    }
    assert paths(row) == [{"name": "ball", "points": [[4, 11], [9, 11], [21, 11]]}]
    assert paths(row | {"context_camera": ["front", "side", "front"]}) == []
    assert paths({"context_camera": ["front"]}) == []


def test_ways_are_drawn(browser: Any, dataset: DatasetReader, tmp_path: Path) -> None:
    def put(content: bytes) -> str:
        (tmp_path / f"{hash(content)}.png").write_bytes(content)
        return f"{hash(content)}.png"

    some = list(records(dataset, 2, put))
    for question in some:
        question["runs"][0]["paths"] = [{"name": "ball", "points": [[5, 5], None, [60, 5]]}]
    (tmp_path / "p.html").write_text(html(about(dataset) | {"questions": some}))
    for tab in opened(browser, tmp_path / "p.html"):
        tab.keyboard.press("z")
        tab.wait_for_function("() => document.querySelector('#canvas').width === 64")
        for _ in range(2):
            tab.keyboard.press("ArrowRight")
        plain = canvas(tab)
        tab.keyboard.press("w")
        drawn = canvas(tab)
        changed = np.nonzero((drawn != plain).any(axis=2))
        assert len(changed[0])
        assert changed[0].max() < len(plain) / 4, "along the top, where the way is"


# ---------------------------------------------------------------- sorting, models, rejections


def test_replies_of_models_stand_beside_the_truth(compared: tuple[Any, Path], answered: Path) -> None:
    tab, _ = compared
    rows = {row["id"]: row for row in results.read(answered / "random.parquet")[0]}
    assert tab.locator(".replies").count() == 0, "not before the truth is shown"
    tab.select_option("#task", "collide")
    tab.wait_for_selector("article")
    id = tab.locator("article").first.get_attribute("data-id")
    tab.locator("article").first.get_by_role("button", name="Show the truth").click()
    said = tab.locator("article").first.locator(".replies tr").all_inner_texts()
    place = ("collide", int(id.split("/")[1]), "", "mujoco")
    (row,) = (r for r in rows.values() if (r["task"], r["index"], r["question_name"], r["engine"]) == place)
    expected = f"{'✓' if row['right'] else '✗'} {'ABCD'[row['parsed']]}"
    assert any("random" in line and "mujoco" in line and expected in line for line in said)
    assert sum("oracle" in line and "✓" in line for line in said) == 3


def test_sorted_by_accuracy_and_counted(compared: tuple[Any, Path]) -> None:
    tab, _ = compared
    whole = counted(tab)
    tab.select_option("#model", "random")
    tab.select_option("#order", "accuracy")
    tab.wait_for_selector("#histogram button")
    bars = tab.locator("#histogram button").evaluate_all("bars => bars.map(bar => bar.ariaLabel)")
    counts = [int(label.rpartition(" ")[2]) for label in bars]
    assert sum(counts) == counted(tab) == whole
    tab.locator("#histogram button").first.click()
    assert counted(tab) == counts[0] < whole
    tab.locator("#histogram button").first.click()
    assert counted(tab) == whole
    tab.select_option("#model", "oracle")
    tab.select_option("#answered", "all right")
    assert counted(tab) == whole


def test_rejected_instances_are_reported_with_their_reasons(page: Any, dataset: DatasetReader) -> None:
    lost = dataset.manifest["rejected"]["list"]
    assert page.inner_text("#rejected summary") == f"Rejected: {len(lost)} alike"
    page.click("#rejected summary")
    assert "aside and heavier: 3.1 cm apart" in page.inner_text("#rejected")
    page.select_option("#task", "collide")
    assert page.locator("#rejected tr").count() == 1 + sum(r["task"] == "collide" for r in lost)


# ---------------------------------------------------------------- coming back


def test_everything_is_there_after_a_reload(compared: tuple[Any, Path]) -> None:
    tab, _ = compared
    tab.select_option("#task", "collide")
    tab.select_option("#factor", "ball_color")
    tab.select_option("#value", "red")
    tab.wait_for_selector("article")
    tab.evaluate("document.activeElement.blur()")
    tab.keyboard.press("1")
    tab.keyboard.press("f")
    score, count = tab.inner_text("#score"), counted(tab)
    tab.wait_for_timeout(1000)  # browsers write what is kept a little later
    tab.reload()
    tab.wait_for_selector("article")
    assert (tab.inner_text("#score"), counted(tab), tab.input_value("#value")) == (score, count, "red")
    assert tab.locator("article .flag[aria-pressed=true]").count() == 1


def test_a_link_leads_to_its_question(compared: tuple[Any, Path], browser: Any) -> None:
    tab, place = compared
    tab.keyboard.press("n")
    tab.wait_for_selector("article")
    link = tab.locator("article a.id").nth(3)
    id, address = link.inner_text(), link.get_attribute("href")
    tab.select_option("#task", "motion_speed")
    tab.goto(f"{(place / 'index.html').as_uri()}{address}")
    tab.wait_for_selector("article.current")
    tab.wait_for_function("id => document.querySelector('article.current').dataset.id === id", arg=id)
    tab.goto(f"{(place / 'index.html').as_uri()}#<img src=x onerror=alert(1)>")
    assert tab.locator("article").count() > 0


def test_notes_are_saved_as_json_and_are_no_markup(compared: tuple[Any, Path]) -> None:
    tab, _ = compared
    bad = "<img src=x onerror=alert(1)></script><script>alert(2)</script>"
    id = tab.locator("article.current").get_attribute("data-id")
    tab.keyboard.press("f")
    tab.keyboard.press("c")
    tab.keyboard.insert_text(bad)
    tab.reload()
    tab.wait_for_selector("article")
    assert tab.locator("article").first.locator("textarea").input_value() == bad
    with tab.expect_download() as saved:
        tab.get_by_role("button", name="Save notes").click()
    said = json.loads(Path(saved.value.path()).read_text())
    assert said["notes"] == [{"id": id, "flag": True, "note": bad}]
    assert tab.locator("img[src=x]").count() == 0


def test_no_text_of_a_dataset_or_of_a_reply_is_markup(browser: Any, dataset: DatasetReader, tmp_path: Path) -> None:
    bad = "</script><script>alert(1)</script><img src=x onerror=alert(2)>{{ script }}"
    some = list(records(dataset, 2, lambda content: "data:,"))
    for question in some:
        for run in question["runs"]:
            run["text"] = run["value"] = bad
            run["context"] = []
            run["options"] = [{"text": bad, "name": bad, "kind": "label", "change": bad} for _ in run["options"]]
            run["replies"] = [{"model": bad, "parsed": 0, "right": False, "status": "answered", "text": bad}]
    content = about(dataset) | {
        "questions": some,
        "rejected": [[bad, 1, 0, bad, bad, bad]],
        "rejections": 1,
        "name": bad,
    }
    (tmp_path / "p.html").write_text(html(content))
    for tab in opened(browser, tmp_path / "p.html"):
        tab.keyboard.press("r")
        assert bad in tab.inner_text("article h2")
        assert bad in tab.inner_text(".replies")
        assert tab.locator("img[src=x]").count() == 0
        assert tab.locator("main script").count() == 0


def test_large_dataset_is_stored_next_to_its_page(compared: tuple[Any, Path], dataset: DatasetReader) -> None:
    tab, place = compared
    assert not any("runs" in q for q in questions(place / "index.html"))
    assert list((place / "questions").glob("*.js"))
    assert all(p.resolve().is_relative_to(place) for p in place.rglob("*"))
    assert tab.locator("article").count() == 10
    assert tab.locator("article").first.locator(".run").count() == 3


@pytest.mark.parametrize("size", [(360, 640), (1280, 900)])
def test_it_is_used_on_a_phone_as_on_a_desk(size: tuple[int, int], browser: Any, gallery: Path) -> None:
    for tab in opened(browser, gallery, has_touch=True, is_mobile=size[0] < 600):
        tab.set_viewport_size({"width": size[0], "height": size[1]})
        tab.locator("article").first.get_by_role("button", name="Large", exact=True).tap()
        tab.wait_for_function("() => document.querySelector('#canvas').width === 64")
        tab.locator("#swap").tap()
        tab.locator("#difference").tap()
        box = tab.locator("#viewer").bounding_box()
        assert box["x"] >= 0
        assert box["x"] + box["width"] <= size[0]
        tab.locator("#close").tap()
        tab.locator("article .flag").first.tap()
        assert tab.locator("article .flag[aria-pressed=true]").count() == 1
        assert tab.evaluate("document.documentElement.scrollWidth") <= size[0]
