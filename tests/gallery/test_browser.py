"""The gallery in a real browser: a person can look, filter, answer, and count."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from tests.browser import barriers, opened
from wmspec.dataset.build.reader import DatasetReader
from wmspec.eval.gallery.gallery import html
from wmspec.eval.gallery.gallery import page as one_page
from wmspec.eval.gallery.records import about, records


def counted(page: Any) -> int:
    """How many questions pass the filters, as the page says."""
    return int(page.inner_text("#where").split(", ")[1].split()[0].replace(",", ""))


def chosen(page: Any, task: str) -> None:
    page.select_option("#task", task)
    page.evaluate("document.activeElement.blur()")


def questions(gallery: Path) -> list[dict[str, Any]]:
    text = gallery.read_text().split('id="data">')[1].split("</script>")[0]
    found: list[dict[str, Any]] = json.loads(text)["questions"]
    return found


# ---------------------------------------------------------------- looking


def test_every_picture_is_shown_in_every_engine(page: Any) -> None:
    chosen(page, "collide")
    first = page.locator("article").first
    assert first.locator(".engine").all_inner_texts() == ["mujoco", "pybullet", "sapien"]
    assert first.locator("img").count() == 3 * (3 + 4)
    page.wait_for_function(
        "() => [...document.querySelectorAll('article')[0].querySelectorAll('img')].every(i => i.naturalWidth)"
    )
    page.select_option("#engine", "sapien")
    assert page.locator("article").first.locator(".engine").all_inner_texts() == ["sapien"]


def test_truth_is_absent_until_requested(page: Any) -> None:
    chosen(page, "collide")
    card = page.locator("article").first
    assert card.locator(".true, .fate, dl").count() == 0
    for word in ("happens", "weaker", "ball_color", "contact("):
        assert word not in card.inner_html()
    card.get_by_role("button", name="Show the truth").click()
    card = page.locator("article").first
    assert card.locator(".true").count() == 3
    said = card.inner_text()
    for word in (
        "this happens",
        "weaker: action push.speed: 0.8 → 0.28",
        "ball_color",
        "contact(ball, victim) = yes",
        "all agree",
    ):
        assert word in said
    page.keyboard.press("r")
    assert page.locator("article").first.locator(".true, dl").count() == 0


# ---------------------------------------------------------------- filtering


def test_filters_leave_what_they_say(page: Any, gallery: Path) -> None:
    every = questions(gallery)
    assert counted(page) == len(every)
    for name, value, kept in (
        ("dimension", "perception", [q for q in every if q["task"] == "motion_speed"]),
        ("dimension", "prediction.mechanistic", [q for q in every if q["task"] == "collide"]),
        ("task", "collide", [q for q in every if q["task"] == "collide"]),
        ("answer", "picture B", [q for q in every if q["answer"] == "picture B"]),
        ("agreement", "all agree", every),
    ):
        page.select_option(f"#{name}", value)
        assert counted(page) == len(kept) > 0, name
        page.select_option(f"#{name}", "")
    assert counted(page) == len(every)


def test_a_factor_is_chosen_and_then_its_value(page: Any, gallery: Path) -> None:
    chosen(page, "collide")
    assert page.locator("#value").is_disabled()
    page.select_option("#factor", "ball_color")
    red = [q for q in questions(gallery) if q["factors"].get("ball_color") == "red"]
    page.select_option("#value", "red")
    assert counted(page) == len(red) > 0
    page.select_option("#factor", "target")
    assert page.locator("#value").input_value() == ""


def test_search_and_nothing_found(page: Any) -> None:
    page.fill("#search", "collide which")
    assert counted(page) > 0
    page.fill("#search", "zebra")
    assert counted(page) == 0
    assert "No question is like that" in page.inner_text("main")


# ---------------------------------------------------------------- answering


def test_quiz_works_with_the_keyboard(page: Any, gallery: Path) -> None:
    chosen(page, "collide")
    first, second = [q for q in questions(gallery) if q["task"] == "collide"][:2]
    page.keyboard.press(str(first["runs"][0]["true"] + 1))
    assert page.inner_text("#score") == "1 of 1 right"
    page.keyboard.press(str((first["runs"][0]["true"] + 1) % 4 + 1))
    assert page.inner_text("#score") == "1 of 1 right", "an answer once given stands"
    page.keyboard.press("j")
    assert page.locator("article.current").get_attribute("data-id") == second["id"]
    page.keyboard.press(str((second["runs"][0]["true"] + 1) % 4 + 1))
    assert page.inner_text("#score") == "1 of 2 right"
    assert page.locator("article.current .wrong").count() > 0
    page.get_by_role("button", name="Start over").click()
    assert page.inner_text("#score") == ""
    assert page.locator(".true").count() == 0


def test_viewer_who_saw_the_truth_cannot_score(page: Any) -> None:
    page.keyboard.press("r")
    page.keyboard.press("1")
    assert page.inner_text("#score") == ""


def test_typing_in_the_search_answers_nothing(page: Any) -> None:
    page.focus("#search")
    page.keyboard.type("123r")
    assert page.inner_text("#score") == ""
    assert page.locator(".true").count() == 0


def test_pages_are_turned(page: Any) -> None:
    assert "page 1 of" in page.inner_text("#where")
    page.keyboard.press("n")
    assert "page 2 of" in page.inner_text("#where")
    page.keyboard.press("k")
    assert "page 1 of" in page.inner_text("#where"), "before the first question of a page is the page before"
    page.keyboard.press("?")
    assert page.get_by_role("dialog").is_visible()


def test_another_engine_leaves_the_question_in_sight(page: Any) -> None:
    for _ in range(6):
        page.keyboard.press("j")
    page.keyboard.press("e")
    assert page.evaluate("document.activeElement.id") == "card-6"
    page.wait_for_function(
        "() => (r => -1 < r.top && r.top < innerHeight)(document.activeElement.getBoundingClientRect())"
    )


# ---------------------------------------------------------------- for everybody


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_there_are_no_barriers(scheme: Any, browser: Any, gallery: Path) -> None:
    for tab in opened(browser, gallery, color_scheme=scheme):
        assert tab.evaluate("document.documentElement.dataset.theme") == scheme
        assert barriers(tab) == []
        tab.keyboard.press("1")
        tab.keyboard.press("r")
        assert barriers(tab) == []
        assert tab.get_by_role("button", name="Option A").count() > 0
        tab.click("#theme")
        assert tab.evaluate("document.documentElement.dataset.theme") != scheme


def test_a_barrier_is_found(browser: Any) -> None:
    tab = browser.new_page()
    tab.set_content('<html lang="en"><title>x</title><main><img src="data:,"><button></button></main></html>')
    assert {found.partition(":")[0] for found in barriers(tab)} == {"image-alt", "button-name"}
    tab.close()


def test_a_narrow_screen_needs_no_scrolling_sideways(browser: Any, gallery: Path) -> None:
    for tab in opened(browser, gallery):
        tab.set_viewport_size({"width": 360, "height": 700})
        tab.keyboard.press("1")
        assert tab.evaluate("document.documentElement.scrollWidth") <= 360


# ---------------------------------------------------------------- one page, many questions


@pytest.fixture
def alone(browser: Any, dataset: DatasetReader, tmp_path: Path) -> Iterator[Any]:
    one_page(dataset, 3, tmp_path / "one.html")
    yield from opened(browser, tmp_path / "one.html")


def test_a_page_alone_has_its_pictures_inside(alone: Any) -> None:
    alone.wait_for_function("() => document.images[0].naturalWidth === 64")
    assert alone.evaluate("[...document.images].every(i => i.src.startsWith('data:image/webp'))")


def test_a_thousand_questions_load_and_are_sifted(browser: Any, dataset: DatasetReader, tmp_path: Path) -> None:
    some = list(records(dataset, 20, lambda png: "missing.png"))
    many = [some[i % len(some)] | {"id": f"{some[i % len(some)]['task']}/{i}"} for i in range(1000)]
    (tmp_path / "many.html").write_text(html(about(dataset) | {"questions": many}))
    tab = browser.new_page()
    tab.goto((tmp_path / "many.html").as_uri())
    assert counted(tab) == 1000
    tab.select_option("#answer", "picture C")
    assert 0 < counted(tab) < 1000
    tab.close()
