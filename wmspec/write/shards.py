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

from wmspec.ask.model import Rejected
from wmspec.write import files
from wmspec.write.plan import Plan, Shard
from wmspec.write.rows import Row, identity, schema, table
from wmspec.write.worker import Outcome

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
    files.write(folder, sidecar(shard), files.text(asdict(record)))
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


def read_record(folder: Path, shard: Shard) -> Record | None:
    """The record of a shard; None if there is none that can be read."""
    try:
        record: dict[str, Any] = json.loads((folder / sidecar(shard)).read_bytes())
        rejected = tuple(Rejected(**r) for r in record.pop("rejected"))
        return Record(**record, rejected=rejected)
    except (FileNotFoundError, ValueError, TypeError, KeyError, AttributeError, RecursionError):
        return None
