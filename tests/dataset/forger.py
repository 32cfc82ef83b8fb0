"""A forger: changes a dataset and rewrites its counts, hashes and other files so that they agree with one another."""

from __future__ import annotations

import hashlib
import io
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from PIL import Image

from wmspec.dataset.build import files
from wmspec.dataset.build.images import encode_webp
from wmspec.dataset.build.plan import fingerprint
from wmspec.dataset.build.shards import parquet

Rows = list[dict[str, Any]]


class Forger:
    """Edits a copy of a dataset in place; `save` makes it consistent."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.manifest = json.loads((folder / files.MANIFEST).read_bytes())
        self.plan = json.loads((folder / files.PLAN).read_bytes())
        self.tables = {path: pq.read_table(folder / path) for path in self.manifest["shards"]}
        self.rows: dict[str, Rows] = {path: table.to_pylist() for path, table in self.tables.items()}

    def of(self, task: str) -> Rows:
        """The rows of the only shard of a task."""
        (path,) = (path for path in self.rows if path.startswith(f"data/{task}/"))
        return self.rows[path]

    def text(self, name: str, change: Callable[[str], str]) -> None:
        """Change a text file, which must change."""
        there = (self.folder / name).read_text()
        assert change(there) != there
        (self.folder / name).write_text(change(there))

    def spec(self, name: str, change: Callable[[str], str]) -> None:
        """Change a spec, with its hashes."""
        entry = self.manifest["specs"][name]
        assert change(entry["text"]) != entry["text"]
        entry["text"] = change(entry["text"])
        entry["sha256"] = self.plan["specs"][name] = hashlib.sha256(entry["text"].encode()).hexdigest()

    def save(self) -> None:
        """Write rows, and manifest and plan with counts and hashes that agree with them."""
        for path, rows in self.rows.items():
            if pa.Table.from_pylist(rows, schema=self.tables[path].schema).equals(
                pq.read_table(self.folder / path), check_metadata=True
            ):
                continue
            content = parquet(pa.Table.from_pylist(rows, schema=self.tables[path].schema))
            (self.folder / path).write_bytes(content)
            self.manifest["shards"][path] = {"rows": len(rows), "sha256": hashlib.sha256(content).hexdigest()}
        for name, task in self.manifest["tasks"].items():
            task["rows"] = {"questions": len(self.of(name))}
            task["instances"] = len(self.plan["tasks"][name])
        self.manifest["rows"] = sum(map(len, self.rows.values()))
        self.manifest["fingerprint"] = fingerprint(self.plan)
        (self.folder / files.PLAN).write_bytes(files.compact_json(self.plan))
        for name in self.manifest["files"]:
            if (self.folder / name).exists():
                self.manifest["files"][name] = files.digest(self.folder / name)
        (self.folder / files.MANIFEST).write_bytes(files.pretty_json(self.manifest))


def move_truth(row: dict[str, Any]) -> None:
    """Make another option the true one, everywhere in the row."""
    old, new = row["answer"], (row["answer"] + 1) % len(row["option_kind"])
    row["answer"] = new
    row["option_kind"] = [
        "truth" if i == new else row["option_kind"][new] if i == old else kind
        for i, kind in enumerate(row["option_kind"])
    ]
    row["agreement"] = [vote | {"answer": new} for vote in row["agreement"]]


def swap_pictures(row: dict[str, Any]) -> None:
    """Exchange the picture of the truth for that of another option."""
    a, b = row["answer"], (row["answer"] + 1) % len(row["option_kind"])
    pictures = row["option_image"]
    pictures[a], pictures[b] = pictures[b], pictures[a]


def dotted(picture: dict[str, Any], side: int = 2) -> dict[str, Any]:
    """The picture with a red dot in its corner."""
    pixels = np.asarray(Image.open(io.BytesIO(picture["bytes"])).convert("RGB")).copy()
    pixels[2 : 2 + side, 2 : 2 + side] = (255, 0, 0)
    return picture | {"bytes": encode_webp(pixels)}


def dot_truth(row: dict[str, Any]) -> None:
    """Put a dot on the true option."""
    row["option_image"][row["answer"]] = dotted(row["option_image"][row["answer"]])


def nudge(picture: dict[str, Any]) -> dict[str, Any]:
    """The picture with one value changed by one."""
    pixels = np.asarray(Image.open(io.BytesIO(picture["bytes"])).convert("RGB")).copy()
    pixels[0, 0, 0] ^= 1
    return picture | {"bytes": encode_webp(pixels)}


def as_rejected(row: dict[str, Any]) -> dict[str, Any]:
    """The rejection that a forger claims for a removed row."""
    known = {key: row[key] for key in ("task", "index", "question", "engine")}
    return known | {"reason": "alike", "detail": "two options look the same", "answer": ""}


def older(forger: Forger) -> None:
    """Claim that another version of the engine made the dataset, so that small differences are accepted."""
    for record in (forger.manifest, forger.plan):
        record["versions"] = record["versions"] | {"mujoco": "3.9.9"}
