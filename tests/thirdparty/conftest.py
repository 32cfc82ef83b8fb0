"""Stages of the catalogue on disk, as `wmspec compile` writes them."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.language.specs import SPECS, task_of
from wmspec.compile.design.design import Design
from wmspec.compile.stage.write import write_stages
from wmspec.core.diagnostics import WmsError


@pytest.fixture(scope="session")
def catalogue(tmp_path_factory: pytest.TempPathFactory) -> dict[str, list[Path]]:
    """Task -> its base layer, a random instance and that one's counterfactuals, for every task of ours."""
    found = {}
    for path in SPECS:
        design = Design(task_of(path))
        folder = tmp_path_factory.mktemp(design.spec.name)
        index, *_ = design.sample(1)
        try:
            found[design.spec.name] = write_stages(design, design[index], folder)
        except WmsError as error:
            if "cannot be executed yet" not in str(error):
                raise
    return found
