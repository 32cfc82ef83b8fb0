"""The folder of a dataset as a whole: begun, gone on with wherever it was left, and finished."""

from __future__ import annotations

import json
import os
import re
import shutil
import time
from collections.abc import Iterable
from datetime import UTC, date, datetime
from pathlib import Path
from typing import Any

from wmspec.core.diagnostics import WmsError
from wmspec.core.safe_io import make_folders, read_plain
from wmspec.dataset.build import checkpoint, files
from wmspec.dataset.build.baselines import Baselines, baselines
from wmspec.dataset.build.card import bibtex, card
from wmspec.dataset.build.croissant import croissant
from wmspec.dataset.build.examples import examples
from wmspec.dataset.build.manifest import Summary, manifest, summary
from wmspec.dataset.build.plan import Plan, Shard, differences
from wmspec.dataset.build.reader import DatasetReader, foreign
from wmspec.dataset.build.rebuild import rebuilt
from wmspec.dataset.build.rows import Row
from wmspec.dataset.build.shards import Record, read_outcomes, read_records, sidecar, write_record, write_shard
from wmspec.dataset.build.worker import Outcome
from wmspec.runtime.questions.model import Rejected

_OURS = ("data", files.EXAMPLES, files.MANIFEST, files.CARD, files.CROISSANT)
_SHARD = re.compile(r"test-\d{5}-of-\d{5}\.parquet")


class Dataset:
    """A dataset in the making. One process writes to a folder at a time; use it in a `with` statement.

    `notices` says what was found wrong in the folder and is made again.
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
        """Begin a dataset, or go on with one of the same plan.

        With `force` a dataset of another plan is removed first. Only files that we write are ever removed.

        Raises:
            WmsError: the folder holds something else or another plan, is being written to, or cannot be written to.
        """
        _today()  # if it cannot be told, better now than when all is made
        scratch = folder / files.PROGRESS
        with files.explained(folder):
            make_folders(scratch)
        dataset = cls(folder, plan, files.lock(scratch / "lock"))
        try:
            with files.explained(folder):
                dataset._begin(force)
        except BaseException:
            dataset.close()
            raise
        return dataset

    def close(self) -> None:
        """Let others write to the folder. Of a dataset that is whole, nothing stays that was there to make it."""
        scratch = self.folder / files.PROGRESS
        if self._finished or [path.name for path in scratch.glob("*")] == ["lock"]:
            shutil.rmtree(scratch, ignore_errors=True)
        os.close(self._lock)

    def __enter__(self) -> Dataset:
        return self

    def __exit__(self, *why: object) -> None:
        self.close()

    def pending(self) -> tuple[Shard, ...]:
        """The shards that are still to be made."""
        return tuple(s for s in self.plan.shards() if s.path not in self._records)

    def keep(self, shard: Shard, index: int, outcome: Outcome) -> None:
        """Write down what came of an instance until its shard is whole. Raises WmsError if it cannot be written."""
        checkpoint.keep(self.folder, self.plan, shard, index, outcome)

    def kept(self, shard: Shard) -> dict[int, Outcome]:
        """What a run that was stopped kept of a pending shard, by the instances' indices."""
        return checkpoint.kept(self.folder, self.plan, shard)

    def write(self, shard: Shard, rows: Iterable[Row], rejected: Iterable[Rejected]) -> None:
        """Write a shard, whole or not at all, in place of what was kept. `rows` come from `rows.encode`, in any order.

        Raises:
            WmsError: it cannot be written.
            ValueError: a question of the shard is missing, foreign or there twice.
        """
        self._records[shard.path] = write_shard(self.folder, self.plan, shard, rows=rows, rejected=rejected)
        checkpoint.discard(self.folder, shard)

    def finish(self) -> Summary:
        """Write the card, the Croissant metadata, and last the manifest, which says that the dataset is whole.

        Raises:
            WmsError: shards are still to be made, or it cannot be written.
        """
        left = self.pending()
        if left:
            raise WmsError(f"{len(left)} shards of {self.folder} are still to be made; run the same command again")
        total = summary(self.plan, self._records)
        whole = manifest(self.plan, self._records, total)
        for name, example in examples(DatasetReader(self.folder, whole)):
            self._put(name, example)
        self._put(files.CARD, card(self.plan, total, self._baselines()).encode())
        described = croissant(self.plan, self._records, bibtex(self.plan, total), self._published())
        self._put(files.CROISSANT, files.text(described))
        self._put(files.MANIFEST, files.text(whole))
        self._finished = True
        return total

    def _baselines(self) -> dict[str, Baselines]:
        """The baselines of the tasks that have questions."""
        shards: dict[str, list[Path]] = {}
        for shard in self.plan.shards():
            if self._records[shard.path].rows:
                shards.setdefault(shard.task.spec.name, []).append(self.folder / shard.path)
        return {name: baselines(paths) for name, paths in shards.items()}

    def _published(self) -> str:
        """The day (YYYY-MM-DD) on which it was first finished, or that SOURCE_DATE_EPOCH says."""
        try:
            there = json.loads(read_plain(self.folder / files.CROISSANT))
            return str(date.fromisoformat(there["datePublished"]))
        except (OSError, ValueError, TypeError, KeyError, RecursionError):
            return _today()

    # ------------------------------------------------------------ beginning

    def _begin(self, force: bool) -> None:
        for part in (self.folder / files.PROGRESS).glob("*.part"):
            part.unlink()  # left by a run that was killed
        there = self._plan()
        if there is None and any((self.folder / name).exists() for name in _OURS):
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
            self._put(files.PLAN, files.lines(here))
        if others := foreign(self.folder, {shard.path for shard in self.plan.shards()}):
            raise WmsError(
                f"{self.folder / others[0]} is none of the dataset's files, and would be loaded with them; "
                "move it away, or choose another folder with -o"
            )
        self._verify()

    def _plan(self) -> dict[str, Any] | None:
        """The plan that the folder holds, as JSON values; None if it holds none, {} if it cannot be read."""
        try:
            record = json.loads(read_plain(self.folder / files.PLAN))
        except FileNotFoundError:
            return rebuilt(self.folder, self.plan)
        except (ValueError, RecursionError):
            return {}
        return record if isinstance(record, dict) else {}

    def _clear(self) -> None:
        for name in (files.MANIFEST, files.CROISSANT):
            (self.folder / name).unlink(missing_ok=True)
        for picture in (self.folder / files.EXAMPLES).glob("*.webp"):
            picture.unlink()
        if (self.folder / files.EXAMPLES).is_dir() and not any((self.folder / files.EXAMPLES).iterdir()):
            (self.folder / files.EXAMPLES).rmdir()
        for task in sorted((self.folder / "data").glob("*/")):
            for shard in filter(lambda p: _SHARD.fullmatch(p.name), list(task.iterdir())):
                shard.unlink()
            if not any(task.iterdir()):
                task.rmdir()
        for record in (self.folder / files.PROGRESS).glob("*/*.json"):
            record.unlink()
        checkpoint.discard_all(self.folder)

    def _verify(self) -> None:
        """Keep the shards whose files are what their records say; the others are made again."""
        records = read_records(self.folder, self.plan.shards())
        for shard in self.plan.shards():
            record, path = records.get(shard.path), self.folder / shard.path
            if record is None or record.fingerprint != self.plan.fingerprint:
                continue
            if not path.is_file():
                self._again(shard, "is gone")
            elif files.digest(path) != record.sha256:
                self._again(shard, "is not as it was written")
            elif again := checkpoint.passing(record.rejected):
                self._unmade(shard, record, again)
            else:
                self._records[shard.path] = record
                checkpoint.discard(self.folder, shard)  # a run was killed between the shard and this
        if self.pending():
            self._reopen()

    def _reopen(self) -> None:
        """What the manifest of a dataset says that is whole no more is written down, shard by shard."""
        for shard in self.plan.shards():
            if shard.path in self._records and not (self.folder / sidecar(shard)).exists():
                write_record(self.folder, shard, self._records[shard.path])
        (self.folder / files.MANIFEST).unlink(missing_ok=True)

    def _again(self, shard: Shard, why: str) -> None:
        self.notices.append(f"{shard.path} {why}; it is made again")
        (self.folder / sidecar(shard)).unlink(missing_ok=True)

    def _unmade(self, shard: Shard, record: Record, again: set[int]) -> None:
        """Make a shard one that is not whole yet: the instances are kept that are not to be tried again."""
        outcomes = read_outcomes(self.folder, shard, record)
        for index in outcomes.keys() - again:
            self.keep(shard, index, outcomes[index])
        (self.folder / sidecar(shard)).unlink(missing_ok=True)
        count = f"{len(again)} instance{'s' if len(again) > 1 else ''}"
        self.notices.append(f"{shard.task.spec.name}: {count} that crashed or took too long are tried again")

    def _put(self, name: str, content: bytes) -> None:
        files.write(self.folder, name, content)


def _today() -> str:
    """The day (YYYY-MM-DD) that SOURCE_DATE_EPOCH says, or this one. Raises WmsError if it says none."""
    said = os.environ.get("SOURCE_DATE_EPOCH")
    try:
        return str(datetime.fromtimestamp(float(said) if said else time.time(), UTC).date())
    except (ValueError, OverflowError, OSError):
        raise WmsError(f"SOURCE_DATE_EPOCH is no time: {said}", help="give seconds since 1970, or unset it") from None
