"""Reading a dataset that is finished: its manifest, its rows in order, and the units of its columns."""

from __future__ import annotations

import json
from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pyarrow as pa
import pyarrow.parquet as pq

from wmspec.core.diagnostics import WmsError
from wmspec.core.places import FilePlace
from wmspec.core.safe_io import plain, read_plain
from wmspec.dataset.build import files
from wmspec.dataset.build.plan import fingerprint
from wmspec.dataset.build.rows import Row
from wmspec.dataset.build.schema import columns_fault, manifest_fault, pictures_fault, row_fault

#: The columns that hold pictures to be looked at, as a list of {bytes, path}.
PICTURES = ("context", "option_image")
#: Columns for programs, which are large.
CHANNELS = ("context_depth", "context_ids")

#: What mends a dataset.
MENDED = "give the command that made the dataset again (`wmspec generate ... -o FOLDER`), it is mended then"


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
            manifest = json.loads(read_plain(place))
        except OSError:
            raise WmsError(f"{folder} holds no finished dataset; make one with `wmspec generate`") from None
        except (ValueError, RecursionError):
            manifest = None
        if fault := manifest_fault(manifest):
            raise WmsError(f"{place} is not one that `wmspec generate` writes: {fault}; {MENDED}")
        _planned(folder, manifest)
        return cls(folder, manifest)

    def damaged(self) -> dict[str, str]:
        """The files of rows that are not what the manifest says, by path, each with what is wrong with it.

        Those too that the manifest does not know, but whoever loads the folder finds. Reads all of them.

        Raises WmsError if a file may not be read.
        """
        wrong = dict.fromkeys(foreign(self.folder, self.manifest["shards"]), "is none of the dataset's files")
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
                    for number, row in _group(file, group, wanted, only):
                        self._check(path, number, row, task)
                        yield row
            except (OSError, pa.ArrowException, ValueError) as error:
                raise _unreadable(self.folder / path, error) from None

    def _check(self, path: str, number: int, row: Row, task: str) -> None:
        """Raise WmsError, which names the file and the row, if a row is none that wmspec writes."""
        if fault := row_fault(row, task, self.engines) or pictures_fault(row, PICTURES):
            raise WmsError(f"row {number + 1}: {fault}", FilePlace(str(self.folder / path)), MENDED)


def foreign(folder: Path, known: Collection[str]) -> list[str]:
    """The files that are loaded as rows of a folder, as its card says, and are none of those known, in order."""
    there = (path.relative_to(folder).as_posix() for path in sorted(folder.glob("data/*/test-*.parquet")))
    return [path for path in there if path not in known]


def plan_beside(folder: Path) -> dict[str, Any]:
    """What `plan.json` says; empty where a dataset came without one, or with what is none."""
    try:
        plan = json.loads(read_plain(folder / files.PLAN))
    except (OSError, ValueError, RecursionError):
        return {}
    return plan if isinstance(plan, dict) else {}


def _planned(folder: Path, manifest: dict[str, Any]) -> None:
    """Raise WmsError if a manifest says otherwise than the plan beside it."""
    plan = plan_beside(folder)
    same = all(plan[key] == manifest[key] for key in plan.keys() & {"seed", "engines", "size", "consensus", "versions"})
    if plan and not (same and fingerprint(plan) == manifest.get("fingerprint")):
        place = folder / files.MANIFEST
        raise WmsError(f"{place} is not of the dataset that {folder / files.PLAN} plans; {MENDED}")


def _digest(path: Path) -> str:
    try:
        return files.digest(path)
    except OSError as error:
        raise _unreadable(path, error) from None


def _group(
    file: pq.ParquetFile, group: int, columns: Sequence[str], only: Collection[int] | None
) -> Iterator[tuple[int, Row]]:
    """The rows of a group, each with its number in the file."""
    if only is not None and not set(file.read_row_group(group, ["index"])["index"].to_pylist()) & set(only):
        return
    before = sum(file.metadata.row_group(g).num_rows for g in range(group))
    for number, row in enumerate(file.read_row_group(group, columns).to_pylist(), before):
        if only is None or row["index"] in only:
            yield number, row


def _opened(path: Path) -> pq.ParquetFile:
    try:
        file = pq.ParquetFile(plain(path))
        fault = columns_fault(file.schema_arrow)
    except (OSError, pa.ArrowException, ValueError) as error:
        raise _unreadable(path, error) from None
    if fault:
        raise WmsError(fault, FilePlace(str(path)), MENDED)
    return file


def _unreadable(path: Path, error: Exception) -> WmsError:
    reason = (str(error).splitlines() or [type(error).__name__])[0][:200]
    return WmsError(f"cannot be read ({reason})", FilePlace(str(path)), MENDED)
