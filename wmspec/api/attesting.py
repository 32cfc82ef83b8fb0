"""Publish hashes of a dataset that stays private."""

from __future__ import annotations

from os import PathLike
from pathlib import Path
from tempfile import TemporaryDirectory

from wmspec.api.agreement import collect_tasks
from wmspec.api.generating import generate
from wmspec.api.loading import Tell, warn
from wmspec.api.profile import check_profile
from wmspec.api.progress import Progress, silent
from wmspec.api.verifying import render_settings, write_specs
from wmspec.dataset.attestation import Attestation, differences
from wmspec.dataset.attestation import attest as attestation_of
from wmspec.dataset.build import files
from wmspec.dataset.build.reader import DatasetReader

#: Every n-th task is in the public sample.
SAMPLE_STRIDE = 10
#: The most instances per task in the public sample.
MAX_SAMPLE_INSTANCES = 50


def attest(
    dataset: str | PathLike[str],
    output: str | PathLike[str],
    *,
    workers: int | None = None,
    progress: Progress = silent,
    tell: Tell = warn,
) -> Attestation:
    """Write the public attestation of a private dataset: `seal.json` with hashes, and a sample dataset `debug`.

    The sample has a tenth of the tasks, at least one, with up to 50 instances each, generated with seed 0.

    Raises:
        WmsError: the dataset is unfinished or damaged, its seed can be guessed, or `output` cannot be written.
    """
    reader, folder = DatasetReader.open(Path(dataset)).intact(), Path(output)
    made = attestation_of(reader)
    shown = set(reader.tasks[::SAMPLE_STRIDE])
    with TemporaryDirectory() as scratch:
        tasks = [t for t in collect_tasks(write_specs(reader, Path(scratch)), 0, tell) if t.name in shown]
        generate(
            tasks,
            folder / "debug",
            per_task=MAX_SAMPLE_INSTANCES,
            backend=",".join(made.engines),
            size=made.size,
            consensus=reader.manifest["consensus"],
            rows=reader.rows_of,
            profile=check_profile(reader.manifest.get("profile", "")),
            **render_settings(reader),
            workers=workers,
            progress=progress,
            tell=tell,
        )
    place = folder / "seal.json"
    with files.with_remedies(place):
        place.write_text(made.text, encoding="utf-8")
    return made


def check(dataset: str | PathLike[str], sealed_as: str | PathLike[str]) -> tuple[str, ...]:
    """Return the differences between a dataset and the attestation in the file `sealed_as`, one sentence each.

    Raises WmsError if there is no dataset or no attestation, or if the dataset is damaged.
    """
    reader = DatasetReader.open(Path(dataset)).intact()
    return tuple(differences(Attestation.read(Path(sealed_as)), reader))
