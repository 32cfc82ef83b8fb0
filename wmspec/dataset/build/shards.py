"""Shards: questions of some instances of a task in one Parquet file, and the record of the file."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass, field
from itertools import groupby
from operator import itemgetter
from pathlib import Path
from typing import Any

import pyarrow as pa
import pyarrow.parquet as pq

from wmspec.core.safe_io import read_bytes, regular_file
from wmspec.dataset.build import files
from wmspec.dataset.build.identity import identity
from wmspec.dataset.build.plan import Plan, Shard
from wmspec.dataset.build.rows import Row, schema, table
from wmspec.dataset.build.worker import Outcome
from wmspec.runtime.questions.model import Rejected

#: Rows in a row group; small, because reading one row decodes the pictures of all.
ROW_GROUP = 16


@dataclass(frozen=True)
class Record:
    """The record of a shard: hash and number of rows of its file, the rejections, and the hashes of its films."""

    fingerprint: str
    sha256: str
    rows: int
    rejected: tuple[Rejected, ...]
    films: Mapping[str, str] = field(default_factory=dict)


def write_shard(
    folder: Path,
    plan: Plan,
    shard: Shard,
    rows: Iterable[Row],
    rejected: Iterable[Rejected],
    films: Mapping[str, str],
) -> Record:
    """Write a shard's file, then its record, so that incomplete shards stay invisible.

    Rows and rejections come in any order. Raises WmsError if they cannot be written, and ValueError unless they account
    for every question of the shard exactly once.
    """
    place = {(i, e): (n, m) for n, i in enumerate(shard.indices) for m, e in enumerate(plan.row_engines)}
    per_engine = plan.rows_of == "engines"

    def order(index: int, engine: str, question: int) -> tuple[int, ...]:
        return *place.get((index, engine if per_engine else None), (-1, -1)), question

    kept = sorted(rows, key=lambda r: order(r["index"], r["engine"], r["question"]))
    lost = sorted(rejected, key=lambda r: order(r.index, r.engine, r.question))
    ids = [r["id"] for r in kept]
    ids += [identity(plan.seed, r.task, r.index, r.question, r.engine if per_engine else None) for r in lost]
    _check_complete(plan.seed, shard, place.keys(), ids)
    content = parquet(table(kept, schema(shard.task.spec, plan.film is not None)))
    files.write(folder, shard.path, content)
    sha256 = hashlib.sha256(content).hexdigest()
    record = Record(plan.fingerprint, sha256, len(kept), tuple(lost), dict(sorted(films.items())))
    write_record(folder, shard, record)
    return record


def _check_complete(seed: int, shard: Shard, expected: Iterable[tuple[int, str | None]], ids: list[str]) -> None:
    """Raise ValueError unless every expected question occurs exactly once in `ids`."""
    task = shard.task.spec.name
    questions = range(len(shard.task.spec.questions))
    due = {identity(seed, task, i, q, e) for i, e in expected for q in questions}
    if len(ids) != len(set(ids)) or set(ids) != due:
        wrong = sorted(due ^ set(ids)) or sorted(i for i in ids if ids.count(i) > 1)
        raise ValueError(f"{shard.path}: missing, foreign or given twice: {', '.join(wrong[:5])}")


def parquet(content: pa.Table) -> bytes:
    """Return a table as a Parquet file; deterministic."""
    sink = pa.BufferOutputStream()
    texts = [f.name for f in content.schema if pa.types.is_string(f.type)]
    how = {"compression": "zstd", "compression_level": 1, "use_dictionary": texts}
    pq.write_table(content, sink, row_group_size=ROW_GROUP, **how)
    return bytes(sink.getvalue())


def read_outcomes(folder: Path, shard: Shard, record: Record) -> dict[int, Outcome]:
    """Return the outcomes of all instances of an intact shard, by index."""
    every = pq.read_table(regular_file(folder / shard.path)).to_pylist()
    rows = {index: tuple(same) for index, same in groupby(every, key=itemgetter("index"))}
    return {
        i: Outcome(
            rows.get(i, ()), tuple(r for r in record.rejected if r.index == i), _films_of(rows.get(i, ()), record)
        )
        for i in shard.indices
    }


def _films_of(rows: Iterable[Row], record: Record) -> dict[str, str]:
    """Return the films that rows refer to, with their hashes: those of their options in all engines."""
    folders = {(path.rpartition("_")[0], Path(path).stem) for row in rows for path in films_of(row)}
    of = {path: (path.rpartition("_")[0], Path(path).name.partition(".")[0]) for path in record.films}
    return {path: sha for path, sha in record.films.items() if of[path] in folders}


def films_of(row: Row) -> Iterable[str]:
    """Return the paths of the films that a row refers to, in its engine."""
    return row.get("option_film") or ([row["film"]] if row.get("film") else [])


def record_path(shard: Shard) -> str:
    """Return the path of a shard's record in the dataset folder."""
    return f"{files.PROGRESS}/{shard.task.spec.name}/{shard.number:05d}.json"


def read_records(folder: Path, shards: Iterable[Shard]) -> dict[str, Record]:
    """Return the readable records of shards by path. For a finished dataset they come from the manifest."""
    finished = _manifest_records(folder)
    there = (
        (shard, _record(folder / record_path(shard)) or _record_from_manifest(finished, shard)) for shard in shards
    )
    return {shard.path: record for shard, record in there if record is not None}


def _record(path: Path) -> Record | None:
    """Return the record in a file; None if it is missing or invalid."""
    try:
        record: dict[str, Any] = json.loads(read_bytes(path))
        rejected = tuple(Rejected(**r) for r in record.pop("rejected"))
        return Record(**record, rejected=rejected)
    except (FileNotFoundError, ValueError, TypeError, KeyError, AttributeError, RecursionError):
        return None


def _manifest_records(folder: Path) -> dict[str, Any]:
    """Return the manifest's shards, and its rejections by task and instance; empty if it is missing or invalid."""
    try:
        manifest: dict[str, Any] = json.loads(read_bytes(folder / files.MANIFEST))
        lost: dict[str, dict[int, list[Rejected]]] = {}
        for each in manifest["rejected"]["list"]:
            lost.setdefault(each["task"], {}).setdefault(each["index"], []).append(Rejected(**each))
        return {"fingerprint": manifest["fingerprint"], "shards": dict(manifest["shards"]), "lost": lost}
    except (FileNotFoundError, NotADirectoryError, ValueError, TypeError, KeyError, AttributeError, RecursionError):
        return {}


def _record_from_manifest(finished: dict[str, Any], shard: Shard) -> Record | None:
    """Return the record of a shard from the manifest."""
    if shard.path not in finished.get("shards", {}):
        return None
    entry, lost = finished["shards"][shard.path], finished["lost"].get(shard.task.spec.name, {})
    rejected = tuple(r for index in shard.indices for r in lost.get(index, ()))
    try:
        return Record(finished["fingerprint"], entry["sha256"], entry["rows"], rejected, dict(entry.get("films", {})))
    except (TypeError, KeyError):
        return None


def write_record(folder: Path, shard: Shard, record: Record) -> None:
    """Write the record of a shard. Raises WmsError if that fails."""
    files.write(folder, record_path(shard), files.pretty_json(asdict(record)))


def shard_entry(record: Record) -> dict[str, Any]:
    """Return the entry of a shard in the manifest."""
    return {"rows": record.rows, "sha256": record.sha256, **({"films": dict(record.films)} if record.films else {})}
