"""Reading a dataset that is finished: its manifest, its rows in order, and the units of its columns."""

from __future__ import annotations

import json
from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pyarrow as pa
import pyarrow.parquet as pq

from wmspec.errors import WmsError
from wmspec.write.rows import Row

#: The columns that hold pictures to be looked at, as a list of {bytes, path}.
PICTURES = ("context", "option_image")
#: Columns for programs, which are large.
CHANNELS = ("context_depth", "context_ids")


@dataclass(frozen=True)
class Finished:
    """A finished dataset: its folder and its manifest as JSON values."""

    folder: Path
    manifest: dict[str, Any]

    @classmethod
    def open(cls, folder: Path) -> Finished:
        """Raises WmsError if there is no finished dataset in the folder."""
        try:
            said = json.loads((folder / "manifest.json").read_bytes())
        except (OSError, ValueError):
            raise WmsError(f"{folder} holds no finished dataset; make one with `wmspec generate`") from None
        if not isinstance(said, dict) or not {"tasks", "shards", "engines"} <= said.keys():
            raise WmsError(f"{folder}/manifest.json is not one that `wmspec generate` writes; make the dataset again")
        return cls(folder, said)

    @property
    def tasks(self) -> tuple[str, ...]:
        """The tasks' names, in order."""
        return tuple(self.manifest["tasks"])

    @property
    def engines(self) -> tuple[str, ...]:
        """The engines' names, in order."""
        return tuple(self.manifest["engines"])

    def shards(self, task: str) -> tuple[str, ...]:
        """The paths of a task's shards in the folder."""
        return tuple(path for path in self.manifest["shards"] if path.startswith(f"data/{task}/"))

    def units(self, task: str) -> dict[str, str]:
        """The SI unit of every column that has one. Raises WmsError if a shard cannot be read."""
        return {
            field.name: field.metadata[b"unit"].decode()
            for path in self.shards(task)[:1]
            for field in _opened(self.folder / path).schema_arrow
            if field.metadata and field.metadata.get(b"unit")
        }

    def rows(
        self, task: str, columns: Sequence[str] | None = None, only: Collection[int] | None = None
    ) -> Iterator[Row]:
        """The rows of a task in order, few in memory at a time: of all instances, or `only` of those named.

        All columns but those of channels, if none are named. Raises WmsError if a shard cannot be read.
        """
        for path in self.shards(task):
            file = _opened(self.folder / path)
            wanted = columns or [name for name in file.schema_arrow.names if name not in CHANNELS]
            try:
                for group in range(file.num_row_groups):
                    yield from _group(file, group, wanted, only)
            except (OSError, pa.ArrowException) as error:
                raise _unreadable(self.folder / path, error) from None


def _group(file: pq.ParquetFile, group: int, columns: Sequence[str], only: Collection[int] | None) -> Iterator[Row]:
    if only is not None and not set(file.read_row_group(group, ["index"])["index"].to_pylist()) & set(only):
        return
    for row in file.read_row_group(group, columns).to_pylist():
        if only is None or row["index"] in only:
            yield row


def _opened(path: Path) -> pq.ParquetFile:
    try:
        return pq.ParquetFile(path)
    except (OSError, pa.ArrowException) as error:
        raise _unreadable(path, error) from None


def _unreadable(path: Path, error: Exception) -> WmsError:
    said = str(error).splitlines()[0]
    return WmsError(f"{path}: cannot be read ({said}); give the command that made the dataset again, it is mended then")
