"""Stages of the catalogue on disk, as `wmspec compile` writes them."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from pathlib import Path

import pytest

from tests.language.specs import SPECS, task_of
from wmspec.compile.design.design import Design
from wmspec.compile.stage.write import write_stages
from wmspec.core.diagnostics import WmsError


@pytest.fixture(scope="session")
def stages(tmp_path_factory: pytest.TempPathFactory) -> Callable[[Path], list[Path]]:
    """The base layer of a spec's task, a random instance and that one's counterfactuals; none if it cannot run yet."""

    @cache
    def written(path: Path) -> list[Path]:
        design = Design(task_of(path))
        index, *_ = design.sample(1)
        try:
            return write_stages(design, design[index], tmp_path_factory.mktemp(design.spec.name))
        except WmsError as error:
            if "cannot be executed yet" not in str(error):
                raise
            return []

    return written


@pytest.fixture(scope="session")
def catalogue(stages: Callable[[Path], list[Path]]) -> dict[str, list[Path]]:
    """Task -> its stages, for every task of ours."""
    return {task_of(path).name: paths for path in SPECS if (paths := stages(path))}
