"""A shard: the questions of some instances of a task as one Parquet file, and the record of how it was made."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterable
from dataclasses import asdict, dataclass
from itertools import groupby
from operator import itemgetter
from pathlib import Path
from typing import Any

import pyarrow as pa
import pyarrow.parquet as pq

from wmspec.core.safe_io import read_plain
from wmspec.dataset.build import files
from wmspec.dataset.build.plan import Plan, Shard
from wmspec.dataset.build.rows import Row, identity, schema, table
from wmspec.dataset.build.worker import Outcome
from wmspec.runtime.questions.model import Rejected

#: Rows read together: few, because a reader who wants one row decodes the pictures of all.
ROW_GROUP = 16


@dataclass(frozen=True)
class Record:
    """What became of a shard: its file's hash and rows, and the instances that yielded no question."""

    fingerprint: str
    sha256: str
    rows: int
    rejected: tuple[Rejected, ...]


def write_shard(folder: Path, plan: Plan, shard: Shard, *, rows: Iterable[Row], rejected: Iterable[Rejected]) -> Record:
    """Write a shard's file, then its record; nothing is seen of a shard that is not whole.

    Rows and rejections may come in any order. Raises WmsError if they cannot be written, and ValueError if they do not
    account for every instance of the shard and no other, each question once.
    """
    place = {(i, e): (n, m) for n, i in enumerate(shard.indices) for m, e in enumerate(plan.engines)}
    kept = sorted(rows, key=lambda r: (*place.get((r["index"], r["engine"]), (-1, -1)), r["question"]))
    lost = sorted(rejected, key=lambda r: (*place.get((r.index, r.engine), (-1, -1)), r.question))
    _accounted(shard, place.keys(), kept, lost)
    content = parquet(table(kept, schema(shard.task.spec)))
    files.write(folder, shard.path, content)
    record = Record(plan.fingerprint, hashlib.sha256(content).hexdigest(), len(kept), tuple(lost))
    write_record(folder, shard, record)
    return record


def _accounted(shard: Shard, expected: Iterable[tuple[int, str]], rows: list[Row], rejected: list[Rejected]) -> None:
    task = shard.task.spec.name
    ids = [r["id"] for r in rows] + [identity(r.task, r.index, r.question, r.engine) for r in rejected]
    questions = range(len(shard.task.spec.questions))
    due = {identity(task, i, q, e) for i, e in expected for q in questions}
    if len(ids) != len(set(ids)) or set(ids) != due:
        wrong = sorted(due ^ set(ids)) or sorted(i for i in ids if ids.count(i) > 1)
        raise ValueError(f"{shard.path}: missing, foreign or given twice: {', '.join(wrong[:5])}")


def parquet(content: pa.Table) -> bytes:
    """A table as a Parquet file: the same bytes for the same rows."""
    sink = pa.BufferOutputStream()
    texts = [f.name for f in content.schema if pa.types.is_string(f.type)]
    how = {"compression": "zstd", "compression_level": 1, "use_dictionary": texts}
    pq.write_table(content, sink, row_group_size=ROW_GROUP, **how)
    return bytes(sink.getvalue())


def read_outcomes(folder: Path, shard: Shard, record: Record) -> dict[int, Outcome]:
    """What came of every instance of a shard that is as its record says, by index."""
    every = pq.read_table(folder / shard.path).to_pylist()
    rows = {index: tuple(same) for index, same in groupby(every, key=itemgetter("index"))}
    return {i: Outcome(rows.get(i, ()), tuple(r for r in record.rejected if r.index == i)) for i in shard.indices}


def sidecar(shard: Shard) -> str:
    """Where a shard's record lies in the dataset's folder."""
    return f"{files.PROGRESS}/{shard.task.spec.name}/{shard.number:05d}.json"


def read_records(folder: Path, shards: Iterable[Shard]) -> dict[str, Record]:
    """The records of shards, by path, but for those that cannot be read. A manifest has those of a finished dataset."""
    finished = _finished(folder)
    there = ((shard, _record(folder / sidecar(shard)) or _recorded(finished, shard)) for shard in shards)
    return {shard.path: record for shard, record in there if record is not None}


def _record(path: Path) -> Record | None:
    try:
        record: dict[str, Any] = json.loads(read_plain(path))
        rejected = tuple(Rejected(**r) for r in record.pop("rejected"))
        return Record(**record, rejected=rejected)
    except (FileNotFoundError, ValueError, TypeError, KeyError, AttributeError, RecursionError):
        return None


def _finished(folder: Path) -> dict[str, Any]:
    """What the manifest says of shards, and of rejections by task and instance; empty if none can be read."""
    try:
        manifest: dict[str, Any] = json.loads(read_plain(folder / files.MANIFEST))
        lost: dict[str, dict[int, list[Rejected]]] = {}
        for each in manifest["rejected"]["list"]:
            lost.setdefault(each["task"], {}).setdefault(each["index"], []).append(Rejected(**each))
        return {"fingerprint": manifest["fingerprint"], "shards": dict(manifest["shards"]), "lost": lost}
    except (FileNotFoundError, NotADirectoryError, ValueError, TypeError, KeyError, AttributeError, RecursionError):
        return {}


def _recorded(finished: dict[str, Any], shard: Shard) -> Record | None:
    """What a manifest says of a shard."""
    if shard.path not in finished.get("shards", {}):
        return None
    entry, lost = finished["shards"][shard.path], finished["lost"].get(shard.task.spec.name, {})
    rejected = tuple(r for index in shard.indices for r in lost.get(index, ()))
    try:
        return Record(finished["fingerprint"], entry["sha256"], entry["rows"], rejected)
    except (TypeError, KeyError):
        return None


def write_record(folder: Path, shard: Shard, record: Record) -> None:
    """Write down how a shard was made. Raises WmsError if that cannot be done."""
    files.write(folder, sidecar(shard), files.text(asdict(record)))
