"""A small dataset with films, made once in a session."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.engines import installed
from tests.shared import Shared
from wmspec.api import generate

SHOVE = Path(__file__).parent / "specs/shove.wms"
OPTIONS = {"backend": "mujoco,pybullet", "size": 64, "film": 8, "film_size": (192, 112)}


@pytest.fixture(scope="session")
def films(shared: Shared) -> Path:
    """Two closed sets of four futures: a ball on the left or right rolls left or right. Two processes make them."""
    for engine in ("mujoco", "pybullet"):
        installed(engine)

    def make(folder: Path) -> None:
        generate(SHOVE, folder / "out", per_task=8, workers=2, **OPTIONS)  # type: ignore[arg-type]

    return shared.folder("films", make) / "out"
