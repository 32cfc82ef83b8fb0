"""A dataset of two tasks in three engines, its gallery, and a browser to look at it."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from tests.browser import opened
from tests.dataset.made import make, plan
from wmspec.dataset.build.reader import DatasetReader
from wmspec.eval.gallery.gallery import folder

__all__ = ["dataset", "gallery", "page"]


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


@pytest.fixture
def page(browser: Any, gallery: Path) -> Iterator[Any]:
    yield from opened(browser, gallery)
