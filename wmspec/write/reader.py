"""Reading a dataset that is finished: its manifest, its rows in order, and the units of its columns."""

from __future__ import annotations

import json
from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pyarrow as pa
import pyarrow.parquet as pq

from wmspec.diagnostics import WmsError
from wmspec.places import FilePlace
from wmspec.write import files
from wmspec.write.rows import Row

#: The columns that hold pictures to be looked at, as a list of {bytes, path}.
PICTURES = ("context", "option_image")
#: Columns for programs, which are large.
CHANNELS = ("context_depth", "context_ids")

#: What mends a dataset.
MENDED = "give the command that made the dataset again (`wmspec generate ... -o FOLDER`), it is mended then"

#: What the manifest says of the whole, of a task and of a shard.
_WHOLE = {"tasks", "shards", "engines", "rows", "seed", "size", "versions", "consensus"}
_TASK = {"dimension", "title", "description", "instances", "rows", "rejected"}
_SHARD = {"sha256", "rows"}


@dataclass(frozen=True)
class DatasetReader:
    """A finished dataset: its folder and its manifest as JSON values."""

    folder: Path
    manifest: dict[str, Any]

    @classmethod
    def open(cls, folder: Path) -> DatasetReader:
        """Raises WmsError if there is no finished dataset in the folder, or if its manifest is damaged."""
        place = folder / files.MANIFEST
        try:
            manifest = json.loads(place.read_bytes())
        except OSError:
            raise WmsError(f"{folder} holds no finished dataset; make one with `wmspec generate`") from None
        except ValueError:
            manifest = None
        if not _as_written(manifest):
            raise WmsError(f"{place} is not one that `wmspec generate` writes; {MENDED}")
        return cls(folder, manifest)

    def damaged(self) -> dict[str, str]:
        """The shards that are not what the manifest says, by path, each with what is wrong with it. Reads all of them.

        Raises WmsError if a file may not be read.
        """
        wrong = {}
        for path, shard in self.manifest["shards"].items():
            file = self.folder / path
            if not file.is_file():
                wrong[path] = "is gone"
            elif _digest(file) != shard["sha256"]:
                wrong[path] = "is not as it was written"
        return wrong

    def intact(self) -> None:
        """Raises WmsError, which names the first shards that are damaged, if some are."""
        wrong = [f"{self.folder / path} {why}" for path, why in self.damaged().items()]
        if wrong:
            more = f", and {len(wrong) - 3:,} more are damaged" if len(wrong) > 3 else ""
            raise WmsError(f"{', '.join(wrong[:3])}{more}; {MENDED}")

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

    def columns(self, task: str) -> tuple[str, ...]:
        """The names of a task's columns; none if it has no rows. Raises WmsError if a shard cannot be read."""
        return tuple(n for path in self.shards(task)[:1] for n in _opened(self.folder / path).schema_arrow.names)

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


def _as_written(manifest: Any) -> bool:
    """Whether a manifest has what one has that we write."""
    return _has(manifest, _WHOLE) and all(
        isinstance(manifest[name], dict) and all(_has(each, keys) for each in manifest[name].values())
        for name, keys in (("tasks", _TASK), ("shards", _SHARD))
    )


def _has(value: Any, keys: set[str]) -> bool:
    return isinstance(value, dict) and keys <= value.keys()


def _digest(path: Path) -> str:
    try:
        return files.digest(path)
    except OSError as error:
        raise _unreadable(path, error) from None


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
    reason = str(error).splitlines()[0]
    return WmsError(f"cannot be read ({reason})", FilePlace(str(path)), MENDED)
