"""Imports a table and a folder of pictures as a finished dataset: shards, card, metadata, manifest."""

from __future__ import annotations

import hashlib
import json
from dataclasses import dataclass
from itertools import islice
from pathlib import Path
from typing import Any

import pyarrow as pa

from wmspec import __version__
from wmspec.core.diagnostics import WmsError
from wmspec.core.places import FilePlace
from wmspec.core.safe_io import make_folders, read_bytes
from wmspec.dataset.build import files
from wmspec.dataset.build.card import configuration
from wmspec.dataset.build.croissant import TaskMetadata, metadata
from wmspec.dataset.build.rows import table
from wmspec.dataset.build.schema import SHARD, manifest_fault
from wmspec.dataset.build.shards import parquet
from wmspec.dataset.build.splits import TEST
from wmspec.eval.image_import.decode import PictureFolder
from wmspec.eval.image_import.rows import CAMERA_ENGINE, rows, schema
from wmspec.eval.image_import.table import Entry, read
from wmspec.eval.image_import.wm_abench import Pictures, read_file, sources

#: Mark in the manifest of an imported dataset, which may be replaced by another import.
PROVENANCE = "recast"


@dataclass(frozen=True)
class ImportResult:
    """The result of an import: questions by task, unused pictures, and the number of rows without a licence."""

    questions: dict[str, int]
    unused: tuple[str, ...]
    unlicensed: int


def import_images(path: Path, folder: Path, output: Path, size: int) -> ImportResult:
    """Import a table as a dataset. Nothing is written unless the whole table is valid.

    Raises WmsError with all errors, or if the folder holds something else or cannot be written.
    """
    if not folder.is_dir():
        raise WmsError(f"{folder} is not a folder; pass the folder of the pictures as --images")
    pictures = PictureFolder(folder, size)
    entries = read(path, pictures)
    tasks: dict[str, list[Entry]] = {}
    for entry in entries:
        tasks.setdefault(entry.task, []).append(entry)
    _check_dimensions(path, tasks)
    _clear(output)
    shards = {
        f"data/{name}/test-00000-of-00001.parquet": (of_one, table(rows(of_one, pictures), schema(of_one)))
        for name, of_one in tasks.items()
    }
    with files.with_remedies(output):
        make_folders(output / files.PROGRESS)
    records = {name: _write_shard(output, name, *shard) for name, shard in shards.items()}
    _finish(output, path, files.digest(path), tasks, records, size)
    unlicensed = sum(not entry.license for entry in entries)
    return ImportResult({name: len(of_one) for name, of_one in tasks.items()}, pictures.unused, unlicensed)


def import_wm_abench(
    folder: Path, output: Path, size: int, dimensions: dict[str, str], limit: int | None = None
) -> ImportResult:
    """Import the released WM-ABench as a dataset, at most `limit` questions of a task, one shard a file.

    Raises WmsError if a file is invalid, or if the output holds something else or cannot be written.
    """
    found = sources(folder, dimensions)
    _clear(output)
    with files.with_remedies(output):
        make_folders(output / files.PROGRESS)
    tasks: dict[str, list[Entry]] = {}
    shards: dict[str, dict[str, Any]] = {}
    for source in found:
        for number, path in enumerate(source.files):
            pictures, known = Pictures(folder, size), tasks.setdefault(source.task, [])
            made = list(
                islice(read_file(source, path, pictures, len(known)), None if limit is None else limit - len(known))
            )
            if made:
                name = f"data/{source.task}/test-{number:05}-of-{len(source.files):05}.parquet"
                content = table(rows(made, pictures, len(known)), schema(made))
                shards[name] = _write_shard(output, name, made, content)
                known += made
    _finish(output, folder, hashlib.sha256(files.pretty_json(shards)).hexdigest(), tasks, shards, size)
    return ImportResult({name: len(of_one) for name, of_one in tasks.items()}, (), 0)


def _check_dimensions(path: Path, tasks: dict[str, list[Entry]]) -> None:
    """Report an error if the rows of a task name several dimensions."""
    for name, entries in tasks.items():
        other = next((e for e in entries if e.dimension != entries[0].dimension), None)
        if other is not None:
            here, there = entries[0], other
            raise WmsError(
                f"task `{name}` is of {there.dimension} here, and of {here.dimension} in line {here.line}",
                FilePlace(str(path), there.line, "column `dimension`"),
                "write one dimension, or two tasks",
            )


def _write_shard(output: Path, name: str, entries: list[Entry], content: pa.Table) -> dict[str, Any]:
    """Write a shard; return its entry in the manifest."""
    written = parquet(content)
    files.write(output, name, written)
    return {"rows": len(entries), "sha256": hashlib.sha256(written).hexdigest()}


def _finish(
    output: Path, source: Path, digest: str, tasks: dict[str, list[Entry]], shards: dict[str, dict[str, Any]], size: int
) -> None:
    """Write card, metadata and manifest of what was imported from a `source` with this digest."""
    files.write(output, files.CARD, _card(source, tasks).encode())
    files.write(output, files.CROISSANT, files.pretty_json(_metadata(tasks)))
    about = {"name": source.name, "sha256": digest}
    files.write(output, files.MANIFEST, files.pretty_json(_manifest(about, tasks, shards, size)))
    (output / files.PROGRESS).rmdir()


def _clear(output: Path) -> None:
    """Remove an earlier import from the folder. Raises WmsError if it holds anything else."""
    with files.with_remedies(output):
        there = sorted(p.name for p in output.iterdir()) if output.exists() else []
    if not there:
        return
    try:
        manifest: Any = json.loads(read_bytes(output / files.MANIFEST))
    except (OSError, ValueError, RecursionError):
        manifest = None
    if manifest_fault(manifest) or manifest.get("made by") != PROVENANCE:
        raise WmsError(f"{output} holds files that `wmspec import-images` did not write; choose another folder with -o")
    with files.with_remedies(output):
        (output / files.MANIFEST).unlink()
        for shard in filter(SHARD.fullmatch, manifest["shards"]):
            (output / shard).unlink(missing_ok=True)
            if not any((output / shard).parent.iterdir()):
                (output / shard).parent.rmdir()


# ---------------------------------------------------------------- metadata


def _manifest(
    about: dict[str, str], tasks: dict[str, list[Entry]], shards: dict[str, dict[str, Any]], size: int
) -> dict[str, Any]:
    return {
        "format": 1,
        "made by": PROVENANCE,
        "table": about,
        "versions": {"wmspec": __version__},
        "seed": 0,
        "engines": [CAMERA_ENGINE],
        "size": [size, size],
        "consensus": "none",
        "tasks": {name: _task(of_one) for name, of_one in tasks.items()},
        "rows": sum(map(len, tasks.values())),
        "rejected": {"count": {}, "list": []},
        "shards": shards,
    }


def _task(entries: list[Entry]) -> dict[str, Any]:
    return {
        "dimension": entries[0].dimension,
        "title": "",
        "description": "Questions about photographs.",
        "license": ", ".join(sorted({e.license for e in entries if e.license})),
        "source": "; ".join(sorted({e.source for e in entries if e.source})),
        "instances": len({e.episode or e.line for e in entries}),
        "rows": {CAMERA_ENGINE: len(entries)},
        "rejected": {},
    }


def _metadata(tasks: dict[str, list[Entry]]) -> dict[str, Any]:
    described = [TaskMetadata(name, "", schema(of_one)) for name, of_one in tasks.items()]
    licenses = sorted({e.license for of_one in tasks.values() for e in of_one if e.license})
    count = sum(map(len, tasks.values()))
    return metadata(
        "-".join([*tasks][:3]), f"{count} questions about photographs, recast by wmspec", "1.0.0", described, licenses
    )


def _card(path: Path, tasks: dict[str, list[Entry]]) -> str:
    entries = [entry for of_one in tasks.values() for entry in of_one]
    licenses = sorted({e.license for e in entries if e.license}) or ["unknown"]
    lines = ["---", "license:", *(f"- {json.dumps(name)}" for name in licenses), "configs:"]
    for name in tasks:
        lines += configuration(name, name, TEST)
    lines += ["---", "", f"# {len(entries):,} questions about photographs", ""]
    lines += [
        f"Recast by wmspec from `{path.name}`. The pictures were turned upright, brought to sRGB, made no larger than",
        "the requested size, and encoded without loss and without metadata.",
        "",
        "| task | dimension | questions |",
        "|---|---|---|",
    ]
    lines += [f"| {name} | {of_one[0].dimension} | {len(of_one):,} |" for name, of_one in tasks.items()]
    lines += ["", "## Pictures", "", "| files | source | licence |", "|---|---|---|"]
    lines += dict.fromkeys(_credit(entry) for entry in entries)
    return "\n".join(lines) + "\n"


def _credit(entry: Entry) -> str:
    names = [*entry.pictures, *(entry.options if entry.pictured else ())]
    cells = (", ".join(dict.fromkeys(names)), entry.source or "not stated", entry.license or "not stated")
    return f"| {' | '.join(' '.join(cell.replace('|', '/').split()) for cell in cells)} |"
