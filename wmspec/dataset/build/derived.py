"""The files of a finished dataset that follow from its plan, its rows and its rejections."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator, Mapping
from datetime import date
from pathlib import Path

from wmspec.core.safe_io import read_bytes
from wmspec.dataset.build import files
from wmspec.dataset.build.baselines import Baselines, baselines
from wmspec.dataset.build.card import bibtex, card
from wmspec.dataset.build.croissant import croissant
from wmspec.dataset.build.manifest import manifest, summary
from wmspec.dataset.build.plan import Plan
from wmspec.dataset.build.reader import DatasetReader
from wmspec.dataset.build.shards import Record
from wmspec.dataset.build.sheet import examples


def derived_files(
    folder: Path, plan: Plan, records: Mapping[str, Record], published: str
) -> Iterator[tuple[str, bytes]]:
    """Yield the path and content of every file that is no shard: plan, examples, card, metadata, then the manifest.

    `published` is the date of publication (YYYY-MM-DD). The manifest holds the hashes of all others. Raises WmsError if
    a shard cannot be read.
    """
    total, hashes = summary(plan, records), dict[str, str]()
    for name, content in _others(folder, plan, records, published):
        hashes[name] = hashlib.sha256(content).hexdigest()
        yield name, content
    yield files.MANIFEST, files.pretty_json(manifest(plan, records, total, dict(sorted(hashes.items()))))


def _others(folder: Path, plan: Plan, records: Mapping[str, Record], published: str) -> Iterator[tuple[str, bytes]]:
    total = summary(plan, records)
    yield files.PLAN, files.compact_json(plan.record)
    yield from examples(DatasetReader(folder, manifest(plan, records, total)))
    yield files.CARD, card(plan, total, _baselines(folder, plan, records)).encode()
    yield files.CROISSANT, files.pretty_json(croissant(plan, records, bibtex(plan, total), published))


def _baselines(folder: Path, plan: Plan, records: Mapping[str, Record]) -> dict[str, Baselines]:
    """Return the baselines of the tasks that have questions."""
    shards: dict[str, list[Path]] = {}
    for shard in plan.shards():
        if records[shard.path].rows:
            shards.setdefault(shard.task.spec.name, []).append(folder / shard.path)
    return {name: baselines(paths) for name, paths in shards.items()}


def publication_date(folder: Path) -> str:
    """Return the date (YYYY-MM-DD) on which a dataset was first completed; '' if its metadata do not have one."""
    try:
        there = json.loads(read_bytes(folder / files.CROISSANT))
        return str(date.fromisoformat(there["datePublished"]))
    except (OSError, ValueError, TypeError, KeyError, RecursionError):
        return ""
