"""Reuse of instances from other folders: merges parts of a dataset and extends datasets.

Files that match their records are used as if they lay in the dataset's own folder. Missing or damaged instances are
made again.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from wmspec.core.diagnostics import WmsError
from wmspec.core.safe_io import read_bytes
from wmspec.dataset.build import files
from wmspec.dataset.build.checkpoint import transient
from wmspec.dataset.build.film_files import damaged_film
from wmspec.dataset.build.plan import Plan, Shard, Task, differences
from wmspec.dataset.build.rebuild import rebuild_plan
from wmspec.dataset.build.shards import Record, read_outcomes, read_records
from wmspec.dataset.build.splits import Split
from wmspec.dataset.build.worker import Outcome


@dataclass(frozen=True)
class ShardFile:
    """A shard file of another folder and its record."""

    folder: Path
    shard: Shard
    record: Record

    def outcomes(self, requested: Iterable[int]) -> dict[int, Outcome]:
        """Return the outcomes of the given instances."""
        outcomes = read_outcomes(self.folder, self.shard, self.record)
        return {i: outcomes[i] for i in requested}

    @property
    def indices(self) -> Iterator[int]:
        """Yield its instances, except those that are to be retried."""
        again = transient(self.record.rejected)
        return (i for i in self.shard.indices if i not in again)


class PriorInstances:
    """The instances of a plan that other folders hold.

    Raises WmsError if a folder holds no dataset, or one that was made with other settings.
    """

    def __init__(self, folders: Iterable[Path], plan: Plan) -> None:
        reusable = (file for folder in folders for file in _files(folder, plan))
        self._files = {(f.shard.task.spec.name, index): f for f in reusable for index in f.indices}

    def outcomes(self, shard: Shard) -> dict[int, Outcome]:
        """Return the outcomes of a shard's instances that were made before, by index."""
        task, requested = shard.task.spec.name, dict[str, tuple[ShardFile, list[int]]]()
        for index in shard.indices:
            if file := self._files.get((task, index)):
                requested.setdefault(f"{file.folder}/{file.shard.path}", (file, []))[1].append(index)
        return {i: outcome for file, indices in requested.values() for i, outcome in file.outcomes(indices).items()}

    def films(self, shard: Shard) -> Iterator[tuple[str, bytes]]:
        """Yield the films of a shard's instances that were made before, by path, each once."""
        given = set[str]()
        for index in shard.indices:
            if file := self._files.get((shard.task.spec.name, index)):
                for path in file.record.films.keys() - given:
                    given.add(path)
                    yield path, read_bytes(file.folder / path)

    def missing(self, shard: Shard) -> tuple[int, ...]:
        """Return the instances of a shard that are still to be made."""
        return tuple(i for i in shard.indices if (shard.task.spec.name, i) not in self._files)


def _files(folder: Path, plan: Plan) -> Iterator[ShardFile]:
    """Yield the files of a folder that match their records."""
    there = _plan(folder, plan)
    records = read_records(folder, there.shards())
    for shard in there.shards():
        record, path = records.get(shard.path), folder / shard.path
        if (
            record
            and record.fingerprint == there.fingerprint
            and files.is_intact(path, record.sha256)
            and not damaged_film(folder, record.films)
        ):
            yield ShardFile(folder, shard, record)


def _plan(folder: Path, plan: Plan) -> Plan:
    """Return the plan of a folder: `plan` with the folder's own instances and split."""
    try:
        path = folder / files.PLAN
        record: Any = json.loads(read_bytes(path)) if path.exists() else rebuild_plan(folder, plan)
        indices = {name: tuple(map(int, numbers)) for name, numbers in record["tasks"].items()}
        split = Split.of(record.get("split"))
    except (OSError, ValueError, TypeError, KeyError, AttributeError, RecursionError):
        raise WmsError(
            f"{folder} holds no dataset that could be reused; name a folder that `wmspec generate` made"
        ) from None
    tasks = tuple(Task(t.spec, indices[t.spec.name]) for t in plan.tasks if t.spec.name in indices)
    there = replace(plan, tasks=tasks, split=split)
    if there.record != record:
        what = "; ".join(differences(record, there.record)) or "parts that this version does not know"
        raise WmsError(
            f"{folder} cannot be reused, it was made with other {what}; give the options that it was made with"
        )
    return there
