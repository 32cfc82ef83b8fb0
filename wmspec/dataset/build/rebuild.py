"""The plan of a folder that has lost it, from its manifest and what its files say."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import pyarrow as pa
import pyarrow.parquet as pq

from wmspec.core.diagnostics import WmsError
from wmspec.core.safe_io import plain
from wmspec.dataset.build import files
from wmspec.dataset.build.plan import Plan, Task
from wmspec.dataset.build.reader import DatasetReader


def rebuilt(folder: Path, like: Plan) -> dict[str, Any] | None:
    """The record of the plan by which a folder was made; None if it has no manifest, or one that says something else.

    Which instances the tasks have is in the rows and among the rejections; all else is as in the plan `like`, which the
    fingerprint in the manifest proves.
    """
    if not (folder / files.MANIFEST).exists():
        return None
    try:
        dataset = DatasetReader.open(folder)
        asked = {name: _indices(dataset, name) for name in dataset.tasks}
    except (WmsError, OSError, pa.ArrowException):
        return None
    known = {task.spec.name: task for task in like.tasks}
    for whole in (like, *(_plans(like, known, asked) if asked.keys() <= known.keys() else ())):
        if whole.fingerprint == dataset.manifest.get("fingerprint"):
            return dict(whole.record)
    return None


def _plans(like: Plan, known: dict[str, Task], asked: dict[str, list[int]]) -> list[Plan]:
    tasks = tuple(Task(task.spec, tuple(asked[name])) for name, task in known.items() if name in asked)
    return [replace(like, tasks=tasks)]


def _indices(dataset: DatasetReader, task: str) -> list[int]:
    """The instances of a task, in order."""
    asked = {r["index"] for r in dataset.manifest["rejected"]["list"] if r["task"] == task}
    for path in dataset.shards(task):
        asked.update(pq.read_table(plain(dataset.folder / path), columns=["index"])["index"].to_pylist())
    return sorted(asked)
