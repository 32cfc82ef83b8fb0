"""Making a part of a dataset again."""

from __future__ import annotations

from os import PathLike
from pathlib import Path, PurePosixPath
from tempfile import TemporaryDirectory
from typing import NamedTuple

from wmspec.api.agreement import effort, gathered
from wmspec.api.loading import Tell, warn
from wmspec.api.progress import Progress, silent
from wmspec.api.task import Task
from wmspec.core.diagnostics import WmsError
from wmspec.core.safe_io import is_name
from wmspec.dataset.build import files
from wmspec.dataset.build.plan import Plan
from wmspec.dataset.build.plan import Task as PlannedTask
from wmspec.dataset.build.reader import DatasetReader, plan_beside
from wmspec.dataset.verify import Verification
from wmspec.dataset.verify import verify as compare
from wmspec.runtime.engines.registry import chosen, drawing, versions
from wmspec.sim.scene.model import Look

LIBRARY = "<library>/"


def verify(
    folder: str | PathLike[str],
    *,
    sample: int | None = 4,
    workers: int | None = None,
    timeout: float = 300.0,
    progress: Progress = silent,
    tell: Tell = warn,
) -> Verification:
    """Make instances of a dataset again, from the specs in its manifest, and compare them with its rows.

    Args:
        folder: the dataset.
        sample: how many instances of each task, spread over it (whole groups of closed sets); all if it is None.
        workers: processes, 0 to have none; one for each core if it is left out.
        timeout: seconds that an instance may take.
        progress: shows how far it has come.
        tell: told what the specs are warned of.

    Raises:
        WmsError: there is no finished dataset, its files are damaged, or its specs cannot be read here.
    """
    dataset = DatasetReader.open(Path(folder))
    dataset.intact()
    with TemporaryDirectory() as scratch:
        tasks = gathered(unpacked(dataset, Path(scratch)), dataset.manifest["seed"], tell)
    known = {task.name: task for task in tasks}
    if unknown := [name for name in dataset.tasks if name not in known]:
        raise WmsError(f"the specs in {dataset.folder / files.MANIFEST} have no task `{unknown[0]}`")
    plan = _plan(dataset, [known[name] for name in dataset.tasks], sample)
    with progress(sum(len(task.indices) for task in plan.tasks), "verifying") as advance:
        return compare(dataset, plan, effort(workers, timeout, plan.engines), advance)


def unpacked(dataset: DatasetReader, scratch: Path) -> list[Path]:
    """The specs of a manifest as files, each with all libraries beside it."""
    texts = {name: spec["text"] for name, spec in dataset.manifest["specs"].items()}
    tasks = {name: text for name, text in texts.items() if not name.startswith(LIBRARY)}
    libraries = {name.removeprefix(LIBRARY): text for name, text in texts.items() if name.startswith(LIBRARY)}
    paths = []
    for number, (name, text) in enumerate(tasks.items()):
        place = scratch / str(number)
        place.mkdir()
        for file, content in {**libraries, PurePosixPath(name).name: text}.items():
            if not is_name(file.removesuffix(".wms")):
                raise WmsError(f"{dataset.folder / files.MANIFEST} has a spec of the name {file[:80]!r}")
            (place / file).write_text(content, encoding="utf-8")
        paths.append(place / PurePosixPath(name).name)
    return paths


def _plan(dataset: DatasetReader, tasks: list[Task], sample: int | None) -> Plan:
    """The dataset's plan, with some of its instances."""
    manifest, plan = dataset.manifest, drawn_in(dataset)
    engines = chosen(",".join(manifest["engines"]))
    drawers = drawing([plan.renderer] if plan.renderer else engines, plan.look)
    return Plan(
        texts={},
        tasks=tuple(PlannedTask(task.spec, _spread(_indices(dataset, task), sample)) for task in tasks),
        engines=engines,
        size=(manifest["size"][0], manifest["size"][1]),
        seed=manifest["seed"],
        consensus=manifest["consensus"],
        look=plan.look,
        samples=plan.samples,
        renderer=plan.renderer,
        versions=versions({*engines, *drawers}, plan.look),
    )


class Drawn(NamedTuple):
    """How a dataset's pictures were drawn."""

    look: Look
    samples: int | None
    renderer: str


def drawn_in(dataset: DatasetReader) -> Drawn:
    """What its plan says; the usual look for an older dataset, and for one that was copied without its plan."""
    plan = plan_beside(dataset.folder)
    return Drawn(plan.get("look", "parity"), plan.get("samples"), plan.get("renderer", ""))


def _indices(dataset: DatasetReader, task: Task) -> list[int]:
    asked = {row["index"] for row in dataset.rows(task.name, ["id", "task", "index", "engine"])}
    asked |= {r["index"] for r in dataset.manifest["rejected"]["list"] if r["task"] == task.name}
    return sorted(asked)


def _spread(indices: list[int], sample: int | None) -> tuple[int, ...]:
    """Some of the instances, from all over."""
    if sample is None or sample >= len(indices):
        return tuple(indices)
    picked = {indices[(2 * i + 1) * len(indices) // (2 * sample)] for i in range(sample)}
    return tuple(i for i in indices if i in picked)
