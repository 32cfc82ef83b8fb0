"""Publishing a dataset without showing it."""

from __future__ import annotations

from os import PathLike
from pathlib import Path
from tempfile import TemporaryDirectory

from wmspec.api.agreement import gathered
from wmspec.api.loading import Tell, warn
from wmspec.api.making import generate
from wmspec.api.progress import Progress, silent
from wmspec.api.verifying import drawn_in, unpacked
from wmspec.dataset.build import files
from wmspec.dataset.build.reader import DatasetReader
from wmspec.dataset.seal import Seal, differences, sealed

#: One in so many tasks is shown, with as many instances at most.
SHOWN, INSTANCES = 10, 50


def seal(
    dataset: str | PathLike[str],
    output: str | PathLike[str],
    *,
    workers: int | None = None,
    progress: Progress = silent,
    tell: Tell = warn,
) -> Seal:
    """Write what can be published of a dataset that stays private: `seal.json`, and a dataset `debug` to try things on.

    That one has a tenth of the tasks, one at least, up to 50 instances of each, made in the same way with seed 0.

    Raises:
        WmsError: there is no finished dataset, it is damaged, its seed can be guessed, or `output` cannot be written.
    """
    reader, folder = DatasetReader.open(Path(dataset)), Path(output)
    reader.intact()
    made = sealed(reader)
    shown = set(reader.tasks[::SHOWN])
    with TemporaryDirectory() as scratch:
        tasks = [t for t in gathered(unpacked(reader, Path(scratch)), 0, tell) if t.name in shown]
        generate(
            tasks,
            folder / "debug",
            per_task=INSTANCES,
            backend=",".join(made.engines),
            size=made.size,
            consensus=reader.manifest["consensus"],
            **drawn_in(reader)._asdict(),
            workers=workers,
            progress=progress,
            tell=tell,
        )
    place = folder / "seal.json"
    with files.explained(place):
        place.write_text(made.text, encoding="utf-8")
    return made


def check(dataset: str | PathLike[str], sealed_as: str | PathLike[str]) -> tuple[str, ...]:
    """What of a dataset is not what the seal in the file `sealed_as` says, in sentences.

    Raises WmsError if there is no dataset, or no seal, or if the dataset is damaged.
    """
    reader = DatasetReader.open(Path(dataset))
    reader.intact()
    return tuple(differences(Seal.read(Path(sealed_as)), reader))
