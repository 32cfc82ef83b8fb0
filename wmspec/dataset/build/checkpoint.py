"""Checkpoints: the finished instances of incomplete shards, one file each, so that an interrupted run loses nothing.

A file is renamed to its final name after it has been written completely. The name ends in the hash of the content.
Files that a power cut truncated, or that were damaged, are ignored and made again. Therefore no write has to wait for
the disk.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterable
from dataclasses import asdict
from pathlib import Path

import pyarrow as pa

from wmspec.core.safe_io import read_bytes
from wmspec.dataset.build import files
from wmspec.dataset.build.film_files import damaged_film
from wmspec.dataset.build.plan import Plan, Shard
from wmspec.dataset.build.rows import schema, table
from wmspec.dataset.build.worker import Outcome
from wmspec.runtime.questions.model import TRANSIENT, Rejected

_SUFFIX = ".instance"


def save(folder: Path, plan: Plan, shard: Shard, index: int, outcome: Outcome) -> None:
    """Save the outcome of an instance. Raises WmsError, and leaves no file, if it cannot be written."""
    rejected = json.dumps([asdict(r) for r in outcome.rejected])
    rows = table(list(outcome.rows), schema(shard.task.spec, plan.film is not None))
    films = json.dumps(dict(outcome.films))
    metadata = {"plan": plan.fingerprint, "index": str(index), "rejected": rejected, "films": films}
    content = _arrow_bytes(rows.replace_schema_metadata(metadata))
    name = f"{index}-{hashlib.sha256(content).hexdigest()}{_SUFFIX}"
    files.write(folder, f"{_folder(shard)}/{name}", content, synced=False)


def load(folder: Path, plan: Plan, shard: Shard) -> dict[int, Outcome]:
    """Return the saved outcomes of a shard by index, except those that are to be retried.

    Raises WmsError if the files may not be read.
    """
    outcomes = {}
    place = folder / _folder(shard)
    with files.with_remedies(place):
        for path in sorted(place.glob(f"*{_SUFFIX}")):
            content = read_bytes(path)
            if path.stem.partition("-")[2] != hashlib.sha256(content).hexdigest():
                continue
            try:
                rows = pa.ipc.open_stream(content).read_all()
                metadata = rows.schema.metadata
                index, made_by = int(metadata[b"index"]), metadata[b"plan"].decode()
                rejected = tuple(Rejected(**r) for r in json.loads(metadata[b"rejected"]))
                films = dict(json.loads(metadata[b"films"]))
            except (pa.ArrowException, ValueError, TypeError, LookupError, RecursionError):
                continue  # written by another plan or program
            if made_by != plan.fingerprint or index not in shard.indices or transient(rejected):
                continue
            if not damaged_film(folder, films):
                outcomes[index] = Outcome(tuple(rows.to_pylist()), rejected, films)
    return outcomes


def transient(rejected: Iterable[Rejected]) -> set[int]:
    """Return the instances whose rejection may be transient, such as timeouts."""
    return {r.index for r in rejected if r.reason in TRANSIENT}


def _arrow_bytes(content: pa.Table) -> bytes:
    """Return a table in Arrow's IPC format, which is about 40 times as fast as Parquet."""
    sink = pa.BufferOutputStream()
    with pa.ipc.new_stream(sink, content.schema) as stream:
        stream.write_table(content)
    return bytes(sink.getvalue())


def discard(folder: Path, shard: Shard) -> None:
    """Remove the checkpoints of a complete shard. Raises WmsError if that fails."""
    place = folder / _folder(shard)
    with files.with_remedies(place):
        _clear(place)


def discard_all(folder: Path) -> None:
    """Remove the checkpoints of all shards of all plans. Raises OSError if that fails."""
    for place in (folder / files.PROGRESS).glob("*/*/"):
        _clear(place)


def _clear(place: Path) -> None:
    if place.is_dir():
        for path in list(place.glob(f"*{_SUFFIX}")):
            path.unlink()
        if not any(place.iterdir()):
            place.rmdir()


def _folder(shard: Shard) -> str:
    """Return the folder of a shard's checkpoints, relative to the dataset folder."""
    return f"{files.PROGRESS}/{shard.task.spec.name}/{shard.number:05d}"
