"""A dataset being written: creation, resumption and completion of its folder."""

from __future__ import annotations

import json
import os
import re
import shutil
from collections.abc import Iterable, Mapping
from datetime import UTC, datetime
from pathlib import Path
from types import MappingProxyType
from typing import Any

from wmspec.core.diagnostics import WmsError
from wmspec.core.safe_io import make_folders, read_bytes
from wmspec.dataset.build import checkpoint, files
from wmspec.dataset.build.derived import derived_files, publication_date
from wmspec.dataset.build.film_files import clear_films, damaged_film
from wmspec.dataset.build.manifest import Summary, summary
from wmspec.dataset.build.plan import Plan, Shard, differences
from wmspec.dataset.build.reader import unlisted_files
from wmspec.dataset.build.rebuild import rebuild_plan
from wmspec.dataset.build.rows import Row
from wmspec.dataset.build.shards import Record, read_outcomes, read_records, record_path, write_record, write_shard
from wmspec.dataset.build.worker import Outcome
from wmspec.runtime.questions.model import Rejected

_OWN_FILES = ("data", files.FILMS, files.EXAMPLES, files.MANIFEST, files.CARD, files.CROISSANT)
_SHARD = re.compile(r"(?:train|validation|test)-\d{5}-of-\d{5}\.parquet")


class Dataset:
    """A dataset being written. One process writes to a folder at a time; use it in a `with` statement.

    `notices` lists the damage found in the folder; the damaged parts are made again.
    """

    def __init__(self, folder: Path, plan: Plan, lock: int) -> None:
        self.folder = folder
        self.plan = plan
        self.notices: list[str] = []
        self._lock = lock
        self._records: dict[str, Record] = {}
        self._finished = False

    @classmethod
    def open(cls, folder: Path, plan: Plan, force: bool = False) -> Dataset:
        """Create a dataset, or resume one of the same plan.

        With `force`, a dataset of another plan is removed first. Only files written by wmspec are ever removed.

        Raises: WmsError: the folder holds something else or another plan, is being written to, or cannot be written to.
        """
        _build_date()  # fail early if the date is invalid
        scratch = folder / files.PROGRESS
        with files.with_remedies(folder):
            make_folders(scratch)
        dataset = cls(folder, plan, files.lock(scratch / "lock"))
        try:
            with files.with_remedies(folder):
                dataset._begin(force)
        except BaseException:
            dataset.close()
            raise
        return dataset

    def close(self) -> None:
        """Release the lock. If the dataset is complete, remove its progress files as well."""
        scratch = self.folder / files.PROGRESS
        if self._finished or [path.name for path in scratch.glob("*")] == ["lock"]:
            shutil.rmtree(scratch, ignore_errors=True)
        os.close(self._lock)

    def __enter__(self) -> Dataset:
        return self

    def __exit__(self, *why: object) -> None:
        self.close()

    def pending(self) -> tuple[Shard, ...]:
        """The shards still to be made."""
        return tuple(s for s in self.plan.shards() if s.path not in self._records)

    def keep(self, shard: Shard, index: int, outcome: Outcome) -> None:
        """Save the outcome of an instance until its shard is complete. Raises WmsError if it cannot be written."""
        checkpoint.save(self.folder, self.plan, shard, index, outcome)

    def kept(self, shard: Shard) -> dict[int, Outcome]:
        """Return the outcomes that an interrupted run saved for a pending shard, by instance index."""
        return checkpoint.load(self.folder, self.plan, shard)

    def keep_films(self, films: Iterable[tuple[str, bytes]]) -> None:
        """Write films that the folder lacks, by path. Raises WmsError if one cannot be written."""
        for path, content in films:
            there = self.folder / path
            if not there.is_file() or read_bytes(there) != content:
                files.write(self.folder, path, content, synced=False)

    def write(
        self,
        shard: Shard,
        rows: Iterable[Row],
        rejected: Iterable[Rejected],
        films: Mapping[str, str] = MappingProxyType({}),
    ) -> None:
        """Write a shard atomically and discard its checkpoints.

        `rows` come from `rows.encode`, in any order; `films` are the SHA-256 of the films that they refer to, by path.

        Raises: WmsError: it cannot be written. ValueError: a question of the shard is missing, foreign or duplicated.
        """
        self._records[shard.path] = write_shard(self.folder, self.plan, shard, rows, rejected, films)
        checkpoint.discard(self.folder, shard)

    def finish(self) -> Summary:
        """Write the derived files, of which the manifest is the last and marks the dataset as complete.

        Raises: WmsError: shards are missing, or a file cannot be written.
        """
        left = self.pending()
        if left:
            raise WmsError(f"{len(left)} shards of {self.folder} are still to be made; run the same command again")
        published = publication_date(self.folder) or _build_date()  # on which it was first completed
        for name, content in derived_files(self.folder, self.plan, self._records, published):
            files.write(self.folder, name, content)
        self._finished = True
        return summary(self.plan, self._records)

    # ------------------------------------------------------------ creation

    def _begin(self, force: bool) -> None:
        """Check the folder, and write the plan if it is new."""
        for part in (self.folder / files.PROGRESS).glob("*.part"):
            part.unlink()  # left by an interrupted run
        there = self._plan()
        if there is None and any((self.folder / name).exists() for name in _OWN_FILES):
            raise WmsError(f"{self.folder} holds files that are not a dataset of wmspec; choose another folder with -o")
        here = self.plan.record
        if there is not None and there != here:
            if not force:
                what = "; ".join(differences(there, here)) or "parts that this version does not know"
                raise WmsError(
                    f"{self.folder} holds another dataset, with other {what}; "
                    "choose another folder with -o, or replace it with --force"
                )
            self._clear()
        if there != here or not (self.folder / files.PLAN).exists():
            files.write(self.folder, files.PLAN, files.compact_json(here))
        if others := unlisted_files(self.folder, {shard.path for shard in self.plan.shards()}):
            raise WmsError(
                f"{self.folder / others[0]} is not part of the dataset but would be loaded with it; "
                "move it away, or choose another folder with -o"
            )
        self._verify()

    def _plan(self) -> dict[str, Any] | None:
        """Return the plan in the folder as JSON values; None if there is none, {} if it cannot be read."""
        try:
            record = json.loads(read_bytes(self.folder / files.PLAN))
        except FileNotFoundError:
            return rebuild_plan(self.folder, self.plan)
        except (ValueError, RecursionError):
            return {}
        return record if isinstance(record, dict) else {}

    def _clear(self) -> None:
        """Remove the files of the dataset."""
        for name in (files.MANIFEST, files.CROISSANT):
            (self.folder / name).unlink(missing_ok=True)
        for picture in (self.folder / files.EXAMPLES).glob("*.webp"):
            picture.unlink()
        if (self.folder / files.EXAMPLES).is_dir() and not any((self.folder / files.EXAMPLES).iterdir()):
            (self.folder / files.EXAMPLES).rmdir()
        clear_films(self.folder)
        for task in sorted((self.folder / "data").glob("*/")):
            for shard in filter(lambda p: _SHARD.fullmatch(p.name), list(task.iterdir())):
                shard.unlink()
            if not any(task.iterdir()):
                task.rmdir()
        for record in (self.folder / files.PROGRESS).glob("*/*.json"):
            record.unlink()
        checkpoint.discard_all(self.folder)

    def _verify(self) -> None:
        """Mark as done the shards whose files match their records; the others are made again."""
        records = read_records(self.folder, self.plan.shards())
        for shard in self.plan.shards():
            record, path = records.get(shard.path), self.folder / shard.path
            if record is None or record.fingerprint != self.plan.fingerprint:
                continue
            if not path.is_file():
                self._again(shard, "is missing")
            elif files.digest(path) != record.sha256:
                self._again(shard, "was modified")
            elif lost := damaged_film(self.folder, record.films):
                self._again(shard, f"refers to {lost}, which is missing or was modified")
            elif again := checkpoint.transient(record.rejected):
                self._unmade(shard, record, again)
            else:
                self._records[shard.path] = record
                checkpoint.discard(self.folder, shard)  # interrupted after the shard was written
        if self.pending():
            self._reopen()

    def _reopen(self) -> None:
        """Re-create per-shard records from the manifest of a dataset that lost files."""
        for shard in self.plan.shards():
            if shard.path in self._records and not (self.folder / record_path(shard)).exists():
                write_record(self.folder, shard, self._records[shard.path])
        (self.folder / files.MANIFEST).unlink(missing_ok=True)

    def _again(self, shard: Shard, why: str) -> None:
        """Note that a shard is made again."""
        self.notices.append(f"{shard.path} {why}; it will be made again")
        (self.folder / record_path(shard)).unlink(missing_ok=True)

    def _unmade(self, shard: Shard, record: Record, again: set[int]) -> None:
        """Turn a shard into an incomplete one: keep the outcomes of all instances that are not to be retried."""
        outcomes = read_outcomes(self.folder, shard, record)
        for index in outcomes.keys() - again:
            self.keep(shard, index, outcomes[index])
        (self.folder / record_path(shard)).unlink(missing_ok=True)
        count = f"{len(again)} instance{'s' if len(again) > 1 else ''}"
        self.notices.append(f"{shard.task.spec.name}: {count} that crashed or took too long are tried again")


def _build_date() -> str:
    """Return the date (YYYY-MM-DD) of SOURCE_DATE_EPOCH, or the current one. Raises WmsError if it is invalid."""
    said = os.environ.get("SOURCE_DATE_EPOCH")
    try:
        return str((datetime.fromtimestamp(float(said), UTC) if said else datetime.now(UTC)).date())
    except (ValueError, OverflowError, OSError):
        raise WmsError(f"SOURCE_DATE_EPOCH is invalid: {said}", help="give seconds since 1970, or unset it") from None
