"""Studies of datasets with drawn pictures."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.dataset.made import make as make_dataset
from tests.dataset.made import plan
from wmspec.dataset.build.reader import DatasetReader
from wmspec.eval.study.make import StudyOptions, make


@pytest.fixture(scope="session")
def dataset(tmp_path_factory: pytest.TempPathFactory) -> DatasetReader:
    place = tmp_path_factory.mktemp("dataset")
    make_dataset(place, plan(count=20, shard=8))
    return DatasetReader.open(place)


@pytest.fixture
def study(dataset: DatasetReader, tmp_path: Path) -> Path:
    """Six questions and one for practice of each of two tasks, for three raters, with two checks of attention."""
    make(dataset, StudyOptions(per_task=6, raters=3, check_every=6), tmp_path / "study")
    return tmp_path / "study"
