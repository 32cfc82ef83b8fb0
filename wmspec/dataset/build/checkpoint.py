"""The instances of a shard that is not whole yet, each in a file, so that a run that is stopped loses none of them.

A file has its name once it is written to its end, whoever kills the run. The name ends in the hash of its content: one
that a power cut took, or that was damaged since, is none and is made again. So nothing waits for the disk here.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterable
from dataclasses import asdict
from pathlib import Path

import pyarrow as pa

from wmspec.dataset.build import files
from wmspec.dataset.build.plan import Plan, Shard
from wmspec.dataset.build.rows import schema, table
from wmspec.dataset.build.worker import Outcome
from wmspec.runtime.questions.model import PASSING, Rejected

_SUFFIX = ".instance"


def keep(folder: Path, plan: Plan, shard: Shard, index: int, outcome: Outcome) -> None:
    """Write down what came of an instance. Raises WmsError, and leaves nothing, if it cannot be written."""
    rejected = json.dumps([asdict(r) for r in outcome.rejected])
    rows = table(list(outcome.rows), schema(shard.task.spec))
    metadata = {"plan": plan.fingerprint, "index": str(index), "rejected": rejected}
    content = _arrow(rows.replace_schema_metadata(metadata))
    name = f"{index}-{hashlib.sha256(content).hexdigest()}{_SUFFIX}"
    files.write(folder, f"{_place(shard)}/{name}", content, synced=False)


def kept(folder: Path, plan: Plan, shard: Shard) -> dict[int, Outcome]:
    """What came of the instances of a shard that were kept, by index, but for those that are to be tried again.

    Raises WmsError if they may not be read.
    """
    outcomes = {}
    place = folder / _place(shard)
    with files.explained(place):
        for path in sorted(place.glob(f"*{_SUFFIX}")):
            content = path.read_bytes()
            if path.stem.partition("-")[2] != hashlib.sha256(content).hexdigest():
                continue
            try:
                rows = pa.ipc.open_stream(content).read_all()
                metadata = rows.schema.metadata
                index, made_by = int(metadata[b"index"]), metadata[b"plan"].decode()
                rejected = tuple(Rejected(**r) for r in json.loads(metadata[b"rejected"]))
            except (pa.ArrowException, ValueError, TypeError, LookupError, RecursionError):
                continue  # somebody else wrote it
            if made_by == plan.fingerprint and index in shard.indices and not passing(rejected):
                outcomes[index] = Outcome(tuple(rows.to_pylist()), rejected)
    return outcomes


def passing(rejected: Iterable[Rejected]) -> set[int]:
    """The instances that may yield their questions another time."""
    return {r.index for r in rejected if r.reason in PASSING}


def _arrow(content: pa.Table) -> bytes:
    """A table in Arrow's own format, which takes a fortieth of the time of Parquet."""
    sink = pa.BufferOutputStream()
    with pa.ipc.new_stream(sink, content.schema) as stream:
        stream.write_table(content)
    return bytes(sink.getvalue())


def discard(folder: Path, shard: Shard) -> None:
    """Remove what was kept of a shard that is whole. Raises WmsError if that cannot be done."""
    place = folder / _place(shard)
    with files.explained(place):
        _clear(place)


def discard_all(folder: Path) -> None:
    """Remove what was kept of all shards, of whatever plan. Raises OSError if that cannot be done."""
    for place in (folder / files.PROGRESS).glob("*/*/"):
        _clear(place)


def _clear(place: Path) -> None:
    if place.is_dir():
        for path in list(place.glob(f"*{_SUFFIX}")):
            path.unlink()
        if not any(place.iterdir()):
            place.rmdir()


def _place(shard: Shard) -> str:
    """Where a shard's instances are kept in the dataset's folder."""
    return f"{files.PROGRESS}/{shard.task.spec.name}/{shard.number:05d}"
