"""What many tests need and takes long to make: made once in a session, whichever process of it comes first."""

from __future__ import annotations

import os
import pickle
from collections.abc import Callable
from pathlib import Path
from shutil import rmtree
from typing import TypeVar

import pytest
from filelock import FileLock

T = TypeVar("T")


class Shared:
    """Folders and values that all test processes of a session share, each under its key."""

    def __init__(self, root: Path) -> None:
        self._root = root
        self._values: dict[str, object] = {}

    def folder(self, key: str, make: Callable[[Path], object]) -> Path:
        """The folder that `make` fills, empty before. Tests read it; those that change something take a copy."""
        place = self._root / key
        done = place.with_name(f"{place.name}.done")
        place.parent.mkdir(parents=True, exist_ok=True)
        with FileLock(place.with_name(f"{place.name}.lock")):
            if not done.exists():
                rmtree(place, ignore_errors=True)  # of a process that failed
                place.mkdir()
                make(place)
                done.touch()
        return place

    def value(self, key: str, make: Callable[[], T]) -> T:
        """What `make` returns, pickled for the other processes. Tests do not change it."""
        if key not in self._values:

            def write(place: Path) -> None:
                (place / "value.pickle").write_bytes(pickle.dumps(make()))

            self._values[key] = pickle.loads((self.folder(key, write) / "value.pickle").read_bytes())
        return self._values[key]  # type: ignore[return-value]


@pytest.fixture(scope="session")
def shared(tmp_path_factory: pytest.TempPathFactory) -> Shared:
    """What tests share in this session; workers of pytest-xdist have folders of their own in a common one."""
    base = tmp_path_factory.getbasetemp()
    return Shared((base.parent if "PYTEST_XDIST_WORKER" in os.environ else base) / "shared")
