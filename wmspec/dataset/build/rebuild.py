"""Recovers the plan of a folder that has lost it, from its manifest and rows."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import pyarrow as pa

from wmspec.core.diagnostics import WmsError
from wmspec.core.parquet_io import read_table
from wmspec.dataset.build import files
from wmspec.dataset.build.plan import Plan, Task
from wmspec.dataset.build.reader import DatasetReader


def rebuild_plan(folder: Path, like: Plan) -> dict[str, Any] | None:
    """Return the record of the plan by which a folder was made; None if its manifest is missing or contradicts `like`.

    The instances of tasks are found in rows and rejections; everything else comes from the plan `like`. The fingerprint
    in the manifest confirms the result.
    """
    if not (folder / files.MANIFEST).exists():
        return None
    try:
        dataset = DatasetReader.open(folder)
        indices = {name: _indices(dataset, name) for name in dataset.tasks}
    except (WmsError, OSError, pa.ArrowException):
        return None
    known = {task.spec.name: task for task in like.tasks}
    plans = [like]
    if indices.keys() <= known.keys():
        tasks = (Task(task.spec, tuple(indices[name])) for name, task in known.items() if name in indices)
        plans.append(replace(like, tasks=tuple(tasks)))
    found = (plan for plan in plans if plan.fingerprint == dataset.manifest.get("fingerprint"))
    return next((dict(plan.record) for plan in found), None)


def _indices(dataset: DatasetReader, task: str) -> list[int]:
    """Return the instances of a task, in order."""
    indices = {r["index"] for r in dataset.manifest["rejected"]["list"] if r["task"] == task}
    for path in dataset.shards(task):
        indices.update(read_table(dataset.folder / path, ["index"])["index"].to_pylist())
    return sorted(indices)
