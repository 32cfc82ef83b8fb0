"""The contact sheet shows every engine, every option, and which of them is true."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from PIL import ImageColor, ImageFont

from tests.dataset.made import make, plan
from wmspec.core.diagnostics import WmsError
from wmspec.dataset.build import typeset
from wmspec.dataset.build.dataset import Dataset
from wmspec.dataset.build.sheet import WIDTH, contact_sheet


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    place = tmp_path_factory.mktemp("dataset")
    make(place, plan())
    return place


def share(sheet: typeset.Picture, color: str) -> float:
    every = sheet.width * sheet.height
    return sum(count for count, seen in sheet.getcolors(every) or () if seen == ImageColor.getrgb(color)) / every


def test_the_sheet_is_wide_bright_and_full(folder: Path) -> None:
    sheet = contact_sheet(folder, 2)
    assert sheet.width == WIDTH
    assert 0.3 < share(sheet, typeset.PAPER) < 0.9
    assert share(sheet, typeset.GREEN) > 0.001
    for sky in ("#dfe6ee", "#e6e6e6", "#e9e4dc"):  # one for each engine
        assert share(sheet, sky) > 0.02


def test_more_instances_make_a_longer_sheet(folder: Path) -> None:
    assert contact_sheet(folder, 1).height < contact_sheet(folder, 2).height


def test_without_a_system_font_it_is_still_drawn(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    found = ImageFont.truetype

    def missing(font: Any, *rest: Any, **more: Any) -> Any:
        if isinstance(font, str):
            raise OSError("cannot open resource")
        return found(font, *rest, **more)

    monkeypatch.setattr(ImageFont, "truetype", missing)
    typeset.font.cache_clear()
    try:
        assert share(contact_sheet(folder, 1), typeset.BLACK) > 0.0005
    finally:
        typeset.font.cache_clear()


def test_a_word_that_is_too_long_is_broken() -> None:
    style = typeset.Style(20)
    long = typeset.paragraph("W" * 500, style, 300)
    assert long.width == 300
    assert long.height > 20 * style.height


def test_unfinished_dataset_is_an_error(tmp_path: Path) -> None:
    with Dataset.open(tmp_path, replace(plan(), seed=3)), pytest.raises(WmsError, match="no finished dataset"):
        contact_sheet(tmp_path)
