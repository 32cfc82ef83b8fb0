"""Instances that were made before, in other folders: shares of a dataset come together, and a dataset grows.

Files are taken that are what their records say, as if they lay in the dataset's own folder; what was not made, or was
damaged since, is made again.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from wmspec.core.diagnostics import WmsError
from wmspec.core.safe_io import read_plain
from wmspec.dataset.build import files
from wmspec.dataset.build.checkpoint import passing
from wmspec.dataset.build.plan import Plan, Shard, Task, differences
from wmspec.dataset.build.rebuild import rebuilt
from wmspec.dataset.build.shards import Record, read_outcomes, read_records
from wmspec.dataset.build.worker import Outcome


@dataclass(frozen=True)
class File:
    """A file of another folder: its shard, and the record of how it was made."""

    folder: Path
    shard: Shard
    record: Record

    def outcomes(self, wanted: Iterable[int]) -> dict[int, Outcome]:
        """What came of these of its instances."""
        outcomes = read_outcomes(self.folder, self.shard, self.record)
        return {i: outcomes[i] for i in wanted}

    @property
    def indices(self) -> Iterator[int]:
        """Its instances, but for those that are to be tried again."""
        again = passing(self.record.rejected)
        return (i for i in self.shard.indices if i not in again)


class Before:
    """What the folders hold of the instances of a plan.

    Raises WmsError if one of them holds no dataset, or one that was made in another way.
    """

    def __init__(self, folders: Iterable[Path], plan: Plan) -> None:
        reusable = (file for folder in folders for file in _files(folder, plan))
        self._files = {(f.shard.task.spec.name, index): f for f in reusable for index in f.indices}

    def outcomes(self, shard: Shard) -> dict[int, Outcome]:
        """What came of the instances of a shard that were made before, by their indices."""
        task, wanted = shard.task.spec.name, dict[str, tuple[File, list[int]]]()
        for index in shard.indices:
            if file := self._files.get((task, index)):
                wanted.setdefault(f"{file.folder}/{file.shard.path}", (file, []))[1].append(index)
        return {i: outcome for file, indices in wanted.values() for i, outcome in file.outcomes(indices).items()}

    def missing(self, shard: Shard) -> tuple[int, ...]:
        """The instances of a shard that are still to be made."""
        return tuple(i for i in shard.indices if (shard.task.spec.name, i) not in self._files)


def _files(folder: Path, plan: Plan) -> Iterator[File]:
    """The files of a folder that are what their records say."""
    there = _plan(folder, plan)
    records = read_records(folder, there.shards())
    for shard in there.shards():
        record, path = records.get(shard.path), folder / shard.path
        if (
            record
            and record.fingerprint == there.fingerprint
            and path.is_file()
            and files.digest(path) == record.sha256
        ):
            yield File(folder, shard, record)


def _plan(folder: Path, plan: Plan) -> Plan:
    """The plan of a folder: this one, but for which instances of the tasks it has."""
    try:
        path = folder / files.PLAN
        record: Any = json.loads(read_plain(path)) if path.exists() else rebuilt(folder, plan)
        indices = {name: tuple(map(int, numbers)) for name, numbers in record["tasks"].items()}
    except (OSError, ValueError, TypeError, KeyError, AttributeError, RecursionError):
        raise WmsError(
            f"{folder} holds no dataset that could be reused; name a folder that `wmspec generate` made"
        ) from None
    tasks = tuple(Task(t.spec, indices[t.spec.name]) for t in plan.tasks if t.spec.name in indices)
    there = replace(plan, tasks=tasks)
    if there.record != record:
        what = "; ".join(differences(record, there.record)) or "parts that this version does not know"
        raise WmsError(
            f"{folder} cannot be reused, it was made with other {what}; give the options that it was made with"
        )
    return there
