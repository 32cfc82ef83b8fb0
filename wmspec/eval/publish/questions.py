"""Questions without answers: what is published of a private dataset."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pyarrow as pa
import pyarrow.parquet as pq

from wmspec.core.diagnostics import WmsError
from wmspec.core.parquet_io import read_table
from wmspec.core.places import FilePlace
from wmspec.core.safe_io import read_bytes
from wmspec.dataset.build import files
from wmspec.dataset.build.reader import DatasetReader
from wmspec.eval.export.folder import Folder
from wmspec.eval.export.rows import SCHEMA as EXPORT_SCHEMA
from wmspec.eval.export.rows import exported_rows
from wmspec.eval.models.prompt import Prompt
from wmspec.eval.models.question import Selection
from wmspec.eval.publish.secret import Secret, canonical

#: The columns of published questions; none depends on an answer.
COLUMNS = ("id", "task", "question", "system", "content", "images", "options", "labels", "unit")
#: The file that describes published questions.
INDEX_FILE = "questions.json"

_FIELDS = [pa.field("unit", pa.string()) if name == "unit" else EXPORT_SCHEMA.field(name) for name in COLUMNS]
_SCHEMA = pa.schema(_FIELDS, metadata=EXPORT_SCHEMA.metadata)


@dataclass(frozen=True)
class Published:
    """Published questions: their digest, prompt, and the options, labels and unit of each by public id."""

    digest: str
    prompt: str
    questions: dict[str, tuple[tuple[str | None, ...], str, str]]


def publish(
    dataset: DatasetReader, selection: Selection, prompt_name: str, prompt: Prompt, secret: Secret, place: Path
) -> int:
    """Write questions without answers to a folder; returns their number.

    Rows are in the order of their public ids, which follows from nothing. Raises WmsError if the folder holds something
    else or cannot be written.
    """
    index_path = place / INDEX_FILE
    if place.exists() and any(place.iterdir()) and not index_path.exists():
        raise WmsError(f"{place} holds files that are no published questions; choose another folder with -o")
    ids, folder = selection.by_task(dataset), Folder(place)
    digests: dict[str, str] = {}
    with files.with_remedies(place):
        for task, of_task in ids.items():
            rows = sorted(_rows(dataset, of_task, prompt, secret), key=lambda row: row["id"])
            digests |= {row["id"]: _digest(row) for row in rows}
            path = folder.path(f"data/{task}.parquet")
            pq.write_table(pa.Table.from_pylist(rows, schema=_SCHEMA), path, compression="zstd", row_group_size=64)
        index = {
            "format": 1,
            "digest": hashlib.sha256(canonical(digests)).hexdigest(),
            "prompt": prompt_name,
            "prompt_hash": prompt.hash,
            "tasks": {task: len(of_task) for task, of_task in ids.items()},
        }
        folder.copy_reader()
        for name in ("README.md", "answer.py"):
            folder.copy(f"eval/publish/files/{name}", name)
        index_path.write_bytes(files.pretty_json(index))
    return len(digests)


def _rows(dataset: DatasetReader, ids: list[str], prompt: Prompt, secret: Secret) -> Iterator[dict[str, Any]]:
    for row in exported_rows(dataset, ids, prompt):
        public = {name: row[name] for name in COLUMNS if name in row}
        yield public | {"id": secret.public_id(row["task"], row["id"]), "unit": row["answer_unit"] or ""}


def _digest(row: dict[str, Any]) -> str:
    """Return the digest of a published question: all that a model is shown."""
    images = [hashlib.sha256(image["bytes"]).hexdigest() for image in row["images"]]
    return hashlib.sha256(canonical({**row, "images": images})).hexdigest()


def read(place: Path) -> Published:
    """Read published questions, without pictures. Raises WmsError if the folder holds none."""
    path = place / INDEX_FILE
    try:
        index = json.loads(read_bytes(path))
        names = ["id", "options", "labels", "unit"]
        rows = [row for task in index["tasks"] for row in read_table(place / f"data/{task}.parquet", names).to_pylist()]
        questions = {row["id"]: (tuple(row["options"] or ()), row["labels"], row["unit"]) for row in rows}
        return Published(index["digest"], index["prompt"], questions)
    except (OSError, ValueError, LookupError, TypeError, RecursionError, pa.ArrowException):
        raise WmsError(
            "no published questions", FilePlace(str(path)), "`wmspec export --to questions` writes them"
        ) from None
