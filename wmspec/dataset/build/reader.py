"""Reading finished datasets: manifest, rows in order, units of columns."""

from __future__ import annotations

import json
from collections.abc import Collection, Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Self

import pyarrow as pa
import pyarrow.parquet as pq

from wmspec.core.diagnostics import WmsError, suggestion
from wmspec.core.parquet_io import batches, open_parquet
from wmspec.core.places import FilePlace
from wmspec.core.safe_io import read_bytes
from wmspec.dataset.build import files
from wmspec.dataset.build.film_files import damaged_film, unlisted_films
from wmspec.dataset.build.plan import fingerprint
from wmspec.dataset.build.rows import Row
from wmspec.dataset.build.schema import columns_fault, manifest_fault, pictures_fault, row_fault
from wmspec.dataset.film.timing import FilmSettings
from wmspec.runtime.questions.consensus import RowsOf

#: The columns with pictures, as lists of {bytes, path}.
PICTURES = ("context", "option_image")
#: Large columns for programs, not read by default.
CHANNELS = ("context_depth", "context_ids")

#: What both the plan and the manifest state.
_SHARED_KEYS = {"seed", "engines", "size", "consensus", "versions", "rows_of", "profile", "film", "split"}

#: Remedy for a damaged dataset.
REPAIR_HINT = "run the command that made the dataset again (`wmspec generate ... -o FOLDER`) to repair it"


@dataclass(frozen=True)
class DatasetReader:
    """A finished dataset: its folder and its manifest as JSON values."""

    folder: Path
    manifest: dict[str, Any]

    @classmethod
    def open(cls, folder: Path) -> DatasetReader:
        """Open a dataset. Raises WmsError if the folder holds no finished dataset or its manifest is damaged."""
        place = folder / files.MANIFEST
        try:
            manifest = json.loads(read_bytes(place))
        except OSError:
            raise WmsError(f"{folder} holds no finished dataset; make one with `wmspec generate`") from None
        except (ValueError, RecursionError):
            manifest = None
        if fault := manifest_fault(manifest):
            raise WmsError(f"{place} is not a manifest of `wmspec generate`: {fault}; {REPAIR_HINT}")
        _check_plan(folder, manifest)
        return cls(folder, manifest)

    def damaged(self) -> dict[str, str]:
        """Return the Parquet files that do not match the manifest, by path, each with the problem.

        Includes files that the manifest does not list but `load_dataset` would find. Reads all files.

        Raises WmsError if a file may not be read.
        """
        wrong = dict.fromkeys(unlisted_files(self.folder, self.manifest["shards"]), "is not part of the dataset")
        if self.film is not None:
            wrong |= dict.fromkeys(unlisted_films(self.folder, self.films), "is not part of the dataset")
        for path, shard in self.manifest["shards"].items():
            file = self.folder / path
            if not file.is_file():
                wrong[path] = "is missing"
            elif _digest(file) != shard["sha256"]:
                wrong[path] = "was modified"
            if lost := damaged_film(self.folder, shard.get("films", {})):
                wrong[lost] = "was modified" if (self.folder / lost).is_file() else "is missing"
        return wrong

    def intact(self) -> Self:
        """Return the dataset. Raises WmsError with the first damaged shards, if any."""
        wrong = [f"{self.folder / path} {why}" for path, why in self.damaged().items()]
        if wrong:
            more = f", and {len(wrong) - 3:,} more are damaged" if len(wrong) > 3 else ""
            raise WmsError(f"{', '.join(wrong[:3])}{more}; {REPAIR_HINT}")
        return self

    @property
    def film(self) -> FilmSettings | None:
        """The settings of the films; None for a dataset without."""
        return FilmSettings.of(self.manifest.get("film"))

    @property
    def films(self) -> dict[str, str]:
        """The SHA-256 of every film by its path."""
        return {path: sha for shard in self.manifest["shards"].values() for path, sha in shard.get("films", {}).items()}

    @property
    def tasks(self) -> tuple[str, ...]:
        """The names of the tasks, in order."""
        return tuple(self.manifest["tasks"])

    @property
    def engines(self) -> tuple[str, ...]:
        """The names of the engines, in order."""
        return tuple(self.manifest["engines"])

    @property
    def rows_of(self) -> RowsOf:
        """Whether a row is a question, or a question in one of the engines, as in datasets before format 3."""
        rows_of: RowsOf = self.manifest.get("rows_of", "engines")
        return rows_of

    def require_engines(self, names: Iterable[str]) -> None:
        """Raise WmsError unless there are rows of each of these engines."""
        for name in names:
            if name not in self.engines:
                raise WmsError(f"the dataset has no engine `{name}`; {suggestion(name, self.engines)}".rstrip("; "))
            if self.rows_of == "questions":
                raise WmsError(
                    "the dataset has one row for each question, which stands for all engines",
                    help="remove --engine, or generate the dataset with --rows engines",
                )

    def shards(self, task: str) -> tuple[str, ...]:
        """Return the paths of a task's shards in the folder."""
        return tuple(path for path in self.manifest["shards"] if path.startswith(f"data/{task}/"))

    def columns(self, task: str) -> tuple[str, ...]:
        """Return the names of a task's columns; empty if it has no rows. Raises WmsError if a shard cannot be read."""
        return tuple(n for path in self.shards(task)[:1] for n in _open_parquet(self.folder / path).schema_arrow.names)

    def units(self, task: str) -> dict[str, str]:
        """Return the SI unit of every column that has one. Raises WmsError if a shard cannot be read."""
        return self._metadata(task, b"unit")

    def dimensions(self, task: str) -> dict[str, str]:
        """Return the dimension of every factor and nuisance by its column; empty for datasets that hold none.

        Raises WmsError if a shard cannot be read.
        """
        return self._metadata(task, b"about")

    def _metadata(self, task: str, key: bytes) -> dict[str, str]:
        """Return a value from the metadata of every column that has it."""
        return {
            field.name: field.metadata[key].decode()
            for path in self.shards(task)[:1]
            for field in _open_parquet(self.folder / path).schema_arrow
            if field.metadata and field.metadata.get(key)
        }

    def rows(
        self, task: str, columns: Sequence[str] | None = None, only: Collection[int] | None = None
    ) -> Iterator[Row]:
        """Yield the rows of a task in order, few in memory at a time: of all instances, or of those in `only`.

        Without `columns`, all except the channels. Raises WmsError if a shard cannot be read.
        """
        for path in self.shards(task):
            yield from self.shard_rows(path, columns, only)

    def shard_schema(self, path: str) -> pa.Schema:
        """Return the columns of a shard with their metadata. Raises WmsError if it cannot be read."""
        return _open_parquet(self.folder / path).schema_arrow

    def shard_rows(
        self, path: str, columns: Sequence[str] | None = None, only: Collection[int] | None = None
    ) -> Iterator[Row]:
        """Yield the rows of a shard as `rows` does. Raises WmsError if it cannot be read."""
        task, file = path.split("/")[1], _open_parquet(self.folder / path)
        selected = columns or [name for name in file.schema_arrow.names if name not in CHANNELS]
        try:
            for group in range(file.num_row_groups):
                for number, row in _group(file, group, selected, only):
                    if fault := row_fault(row, task, self.engines) or pictures_fault(row, PICTURES):
                        raise WmsError(f"row {number + 1}: {fault}", FilePlace(str(self.folder / path)), REPAIR_HINT)
                    yield row
        except (OSError, pa.ArrowException, ValueError) as error:
            raise _unreadable(self.folder / path, error) from None


def unlisted_files(folder: Path, known: Collection[str]) -> list[str]:
    """Return the files that `load_dataset` would load from a folder and that are not in `known`, in order."""
    there = (path.relative_to(folder).as_posix() for path in sorted(folder.glob("data/*/*-*.parquet")))
    return [path for path in there if path not in known]


def read_plan(folder: Path) -> dict[str, Any]:
    """Return the content of `plan.json`; empty if it is missing or invalid."""
    try:
        plan = json.loads(read_bytes(folder / files.PLAN))
    except (OSError, ValueError, RecursionError):
        return {}
    return plan if isinstance(plan, dict) else {}


def _check_plan(folder: Path, manifest: dict[str, Any]) -> None:
    """Raise WmsError if a manifest contradicts the plan in its folder."""
    plan = read_plan(folder)
    same = all(plan[key] == manifest.get(key) for key in plan.keys() & _SHARED_KEYS)
    if plan and not (same and fingerprint(plan) == manifest.get("fingerprint")):
        place = folder / files.MANIFEST
        raise WmsError(f"{place} is not of the dataset that {folder / files.PLAN} plans; {REPAIR_HINT}")


def _digest(path: Path) -> str:
    """Return the SHA-256 of a file. Raises WmsError if it may not be read."""
    try:
        return files.digest(path)
    except OSError as error:
        raise _unreadable(path, error) from None


def _group(
    file: pq.ParquetFile, group: int, columns: Sequence[str], only: Collection[int] | None
) -> Iterator[tuple[int, Row]]:
    """Yield the rows of a row group, each with its number in the file."""
    if only is not None:
        indices = (index for batch in batches(file, ["index"], [group]) for index in batch["index"].to_pylist())
        if not set(indices) & set(only):
            return
    number = sum(file.metadata.row_group(g).num_rows for g in range(group))
    for batch in batches(file, columns, [group]):
        for row in batch.to_pylist():
            if only is None or row["index"] in only:
                yield number, row
            number += 1


def _open_parquet(path: Path) -> pq.ParquetFile:
    """Open a Parquet file and check its columns."""
    try:
        file = open_parquet(path)
        fault = columns_fault(file.schema_arrow)
    except (OSError, pa.ArrowException, ValueError) as error:
        raise _unreadable(path, error) from None
    if fault:
        raise WmsError(fault, FilePlace(str(path)), REPAIR_HINT)
    return file


def _unreadable(path: Path, error: Exception) -> WmsError:
    reason = (str(error).splitlines() or [type(error).__name__])[0][:200]
    return WmsError(f"cannot be read ({reason})", FilePlace(str(path)), REPAIR_HINT)
