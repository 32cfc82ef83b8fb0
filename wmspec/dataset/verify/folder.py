"""The files of a dataset's folder: which there are, and which follow from its rows."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from pathlib import Path

from wmspec.core.diagnostics import WmsError
from wmspec.core.limits import FOLDER_FILES
from wmspec.core.safe_io import load_image, read_bytes
from wmspec.dataset.build import files
from wmspec.dataset.build.derived import derived_files, publication_date
from wmspec.dataset.build.images import WEBP
from wmspec.dataset.build.plan import Plan
from wmspec.dataset.build.reader import DatasetReader
from wmspec.dataset.build.shards import Record
from wmspec.dataset.verify.compare import NEAR_PIXELS, pixel_difference
from wmspec.dataset.verify.model import Difference

#: What hubs and version control put beside a dataset, and the state of an unfinished run: never loaded as data.
IGNORED = (".git", ".gitattributes", ".cache", files.PROGRESS)


def folder_files(folder: Path) -> Iterator[str]:
    """Yield the paths in a folder, in order, of everything that is no folder.

    Links to folders are not followed. Raises WmsError if there are too many, or if a folder cannot be read.
    """

    def fail(error: OSError) -> None:
        raise WmsError(f"{error.filename} cannot be read: {error.strerror}") from error

    count = 0
    for place, folders, names in os.walk(folder, onerror=fail):
        ignored = IGNORED if Path(place) == folder else ()
        folders[:] = sorted(name for name in folders if name not in ignored)
        links = [name for name in folders if (Path(place) / name).is_symlink()]
        for name in sorted([*(name for name in names if name not in ignored), *links]):
            count += 1
            if count > FOLDER_FILES.most:
                raise WmsError(f"{folder} {FOLDER_FILES.sentence}", help=FOLDER_FILES.help)
            yield (Path(place) / name).relative_to(folder).as_posix()


def folder_differences(dataset: DatasetReader, plan: Plan, records: Mapping[str, Record]) -> Iterator[Difference]:
    """Yield the files that are missing, added, or not what follows from plan, rows and rejections.

    `plan` and `records` are those of the whole dataset, recomputed.
    """
    present, expected = set(folder_files(dataset.folder)), {shard.path for shard in plan.shards()}
    expected |= {path for record in records.values() for path in record.films}
    for name, content in derived_files(dataset.folder, plan, records, publication_date(dataset.folder)):
        expected.add(name)
        if name in present:
            yield from _changed(dataset.folder, name, content)
    yield from (Difference(name, "", "is missing") for name in sorted(expected - present))
    yield from (Difference(name, "", "is not part of the dataset") for name in sorted(present - expected))


def _changed(folder: Path, name: str, content: bytes) -> Iterator[Difference]:
    """Yield the difference of a file from its expected content."""
    try:
        there = read_bytes(folder / name)
    except OSError as error:
        yield Difference(name, "", f"cannot be read: {error.strerror}")
        return
    if there == content:
        return
    if name.endswith(".webp"):
        try:
            load_image(there, WEBP)
            apart = pixel_difference(there, content)
        except WmsError as error:
            yield Difference(name, "", str(error))
            return
        near = apart is not None and bool(apart.mean() < NEAR_PIXELS)
        yield Difference(name, "", "is not the picture that the rows give", near)
        return
    yield Difference(name, "", f"is not what specs, seed and rows give{_first_line(there, content)}")


def _first_line(there: bytes, here: bytes) -> str:
    """Return the first line that differs, in words."""
    pairs = zip(there.decode(errors="replace").splitlines(), here.decode(errors="replace").splitlines(), strict=False)
    for number, (a, b) in enumerate(pairs, 1):
        if a != b:
            return f", from line {number}: {a.strip()[:80]!r}, expected {b.strip()[:80]!r}"
    return ", which is longer" if len(there) < len(here) else ", which is shorter"
