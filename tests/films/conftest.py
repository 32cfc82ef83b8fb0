"""Small datasets with films, made once in a session."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.engines import installed
from tests.shared import Shared
from wmspec.api import generate

SPECS = Path(__file__).parent / "specs"
SHOVE, PUSH = SPECS / "shove.wms", SPECS / "push.wms"
OPTIONS = {"backend": "mujoco,pybullet", "size": 64, "film": 8, "film_size": (192, 112)}
PAIRS = OPTIONS | {"backend": "mujoco"}


@pytest.fixture(scope="session")
def films(shared: Shared) -> Path:
    """Two closed sets of four futures: a ball on the left or right rolls left or right."""
    for engine in ("mujoco", "pybullet"):
        installed(engine)

    def make(folder: Path) -> None:
        generate(SHOVE, folder / "out", per_task=8, workers=0, **OPTIONS)  # type: ignore[arg-type]

    return shared.folder("films", make) / "out"


@pytest.fixture(scope="session")
def pairs(shared: Shared) -> Path:
    """Two closed sets of two futures: a ball rolls left or right, in one engine. Two processes make them."""
    installed("mujoco")

    def make(folder: Path) -> None:
        generate(PUSH, folder / "out", per_task=4, workers=2, **PAIRS)  # type: ignore[arg-type]

    return shared.folder("pairs of films", make) / "out"
