"""A dataset of two tasks in three engines, made once in a session."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.endtoend.test_commands import SPEED
from tests.engines import installed
from tests.shared import Shared
from wmspec.api import generate
from wmspec.api.generating import DatasetOptions

#: Pictures as options, and a label: an episode takes a fifth of those of `collide`.
SHOVE = Path(__file__).parents[1] / "films/specs/shove.wms"
#: The options of the dataset. Its seed is long, since it is attested.
OPTIONS: DatasetOptions = {"per_task": 2, "size": 64, "seed": 6917529027641081977, "backend": "mujoco,pybullet,sapien"}


@pytest.fixture(scope="session")
def dataset(shared: Shared) -> Path:
    """Labels, pictures and numbers, made in this process."""
    for engine in ("mujoco", "pybullet", "sapien"):
        installed(engine)

    def make(folder: Path) -> None:
        generate([SPEED, SHOVE], folder / "whole", workers=0, **OPTIONS)

    return shared.folder("three engines", make) / "whole"
