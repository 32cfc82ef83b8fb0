"""Results of instances on disk, by content: an instance that was executed before is not executed again.

The key of a result is a digest of everything that it depends on: the checked task without its places in the text, the
files that it names, seed and index, the tolerances, the engines and their versions, wmspec's code and the packages that
compute, and the kind of machine. No path and no time of change is part of it, so that machines can share the entries.
"""

from __future__ import annotations

import json
import platform
import re
import sys
from collections.abc import Iterable, Mapping
from dataclasses import asdict
from functools import cache
from pathlib import Path

from pydantic import TypeAdapter, ValidationError

from wmspec.core.code_digest import code_digest
from wmspec.core.disk_cache import DiskCache, digest
from wmspec.core.safe_io import regular_file
from wmspec.runtime.compare.model import CheckResult
from wmspec.runtime.compare.sweep import SweepConfig
from wmspec.runtime.engines.registry import backend_digest, engine_version

#: Version of keys and entries.
FORMAT = 1
#: With more entries than this (about 10 kB each), the older half is removed.
MAX_ENTRIES = 20_000
#: Files that refer to others, which count too.
_REFERRING = frozenset({".dae", ".gltf", ".obj", ".toml", ".urdf", ".usd", ".usda", ".usdc", ".usdz", ".xml"})
#: Files that others may refer to.
_REFERRED = _REFERRING | frozenset({".bin", ".glb", ".jpeg", ".jpg", ".mtl", ".off", ".ply", ".png", ".stl"})
_PLACE = re.compile(r'"place":\{"file":"(?:[^"\\]|\\.)*"[^{}]*\}')


class ResultCache:
    """The results of one crosscheck in a folder. `assets` are the files that each task names."""

    def __init__(self, folder: Path, job: SweepConfig, assets: Mapping[str, Iterable[Path]]) -> None:
        self._store = DiskCache(folder, MAX_ENTRIES)
        limits = dict(job.tolerances)
        shared = [FORMAT, code_digest(), sys.platform, platform.machine(), job.seed]
        shared += [(name, engine_version(name), backend_digest(name)) for name in job.engines]
        self._keys = {
            task: digest(repr([*shared, asdict(limits[task]), _without_places(text), _state(assets[task])]).encode())
            for task, text in job.tasks
        }

    @property
    def refused(self) -> int:
        """The number of entries that were damaged, foreign or writable by others."""
        return self._store.refused

    def find(self, task: str, index: int) -> CheckResult | None:
        """Return the result of an instance, or None if there is none that can be trusted."""
        key = self._key(task, index)
        content = self._store.read(_name(key))
        if content is None:
            return None
        try:
            record = json.loads(content)
            result = _adapter().validate_json(record["result"], strict=True)
            if record["key"] == key and (result.task, result.index) == (task, index):
                return result
        except (ValueError, TypeError, KeyError, ValidationError):
            pass
        self._store.refused += 1
        return None

    def keep(self, result: CheckResult) -> None:
        """Store a result, unless something could not be executed: that may have other causes, and is cheap."""
        if result.failures:
            return
        text = _adapter().dump_json(result)
        if _adapter().dump_json(_adapter().validate_json(text, strict=True)) == text:  # else not a number somewhere
            key = self._key(result.task, result.index)
            self._store.write(_name(key), json.dumps({"key": key, "result": text.decode()}).encode())

    def _key(self, task: str, index: int) -> str:
        return digest(f"{self._keys[task]} {index}".encode())


def _name(key: str) -> str:
    return f"{key[:40]}.json"


@cache
def _adapter() -> TypeAdapter[CheckResult]:
    return TypeAdapter(CheckResult)


def _without_places(text: str) -> str:
    """Return the JSON of a task without the places in its text, which a comment moves."""
    return _PLACE.sub('"place":null', text)


def _state(paths: Iterable[Path]) -> list[tuple[str, str]]:
    """Return name and digest of each file, and of those that it may refer to."""
    files: dict[str, str] = {}
    for path in sorted(paths):
        files[path.name] = files.get(path.name, "") + _content(path)
        if path.suffix.lower() in _REFERRING:
            near = sorted(p for p in path.parent.rglob("*") if p.suffix.lower() in _REFERRED)
            files |= {str(p.relative_to(path.parent)): _content(p) for p in near}
    return sorted(files.items())


def _content(path: Path) -> str:
    try:
        return digest(regular_file(path).read_bytes())
    except OSError:
        return "absent"
